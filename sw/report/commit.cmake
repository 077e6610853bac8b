# SPDX-License-Identifier: Apache-2.0
#
# Writes OUT from IN with the commit of SOURCE in it, with "+" when tracked files differ from it; keeps the
# date of OUT when nothing changes.  Runs at every build.

execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=12 --exclude=* --dirty=+
  OUTPUT_VARIABLE TI_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
configure_file(${IN} ${OUT} @ONLY)
