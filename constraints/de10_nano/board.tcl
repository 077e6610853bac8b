# SPDX-License-Identifier: Apache-2.0
set tool quartus
set family "Cyclone V"
set part 5CSEBA6U23I7
