# SPDX-License-Identifier: Apache-2.0
set tool vivado
set part xcu55c-fsvh2892-2L-e
