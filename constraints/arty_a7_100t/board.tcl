# SPDX-License-Identifier: Apache-2.0
set tool vivado
set part xc7a100tcsg324-1
