# SPDX-License-Identifier: Apache-2.0
#
# What the code of every model includes of Verilator, compiled once for all simulations of tb/unit:
# `make -C FOLDER -f tb/headers.mk` leaves headers.h.gch there.  The flags are those of a model in
# the build of agents/bench.py; a compiler refuses headers that were compiled with others.

.DEFAULT_GOAL := headers.h.gch
VERILATOR_ROOT := $(shell verilator --getenv VERILATOR_ROOT)
VM_COVERAGE := 1
VM_SC := 0
VM_TIMING := 0
VM_TRACE := 0
VM_TRACE_FST := 0
VM_TRACE_SAIF := 0
VM_TRACE_VCD := 0
VM_USER_CFLAGS := $(MODEL_FLAGS)
include $(VERILATOR_ROOT)/include/verilated.mk

# Bytes that depend on nothing but the headers and where they are, so that ccache knows them again.
clang_flags := -fpch-instantiate-templates -Xclang -fno-pch-timestamp

headers.h:
	printf '#include "%s"\n' verilated.h verilated_cov.h verilated_dpi.h >$@

# The result names headers.h by the path that it is given here.
headers.h.gch: headers.h $(wildcard $(VERILATOR_ROOT)/include/*.h)
	$(OBJCACHE) $(CXX) $(OPT_FAST) $(CXXFLAGS) $(CPPFLAGS) $(CFG_CXXFLAGS_PCH) $(if $(findstring clang,$(CXX)),$(clang_flags)) $(abspath $<) -o $@
