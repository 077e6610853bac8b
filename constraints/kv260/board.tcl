# SPDX-License-Identifier: Apache-2.0
set tool vivado
set part xck26-sfvc784-2LV-c
