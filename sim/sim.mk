# SPDX-License-Identifier: Apache-2.0
#
# Builds the RTL, `ti_engine` or with `top=ti_top` that, as a library in the folder `engine`, whose `config`
# scripts/configure.py wrote.  With `waves=1` it can write a dump of all signals, and is some times as slow.
# Run by scripts/build_engine.sh, in the environment of the Makefile.

SHELL := /bin/bash
MAKEFLAGS += --no-print-directory
.SUFFIXES:
.DELETE_ON_ERROR:

q = '$(subst ','\'',$($(1)))'
config := $(engine)/config
waves ?=
top ?= ti_engine
verilated := $(engine)/verilated
library := $(engine)/libti_rtl.so
what ?= $(notdir $(engine))
cxx := $(shell sed -n 1p build/setup.stamp)
rtl_sources := $(wildcard rtl/*.sv rtl/*/*.sv rtl/*/*.svh rtl/*/*/*.sv) rtl/ti.f lint/verilator.vlt $(wildcard sim/sim.vlt sim/*.sv)
harness_sources := $(if $(filter ti_top,$(top)),$(wildcard sim/top/*.cpp) sim/make_memory.cpp,$(wildcard sim/*.cpp))
harness := $(patsubst sim/%.cpp,$(engine)/obj/%.o,$(harness_sources))
# The DRAM where it was built (sim/dram/dram.mk), else what says that it is not there.
dram_library := build/dram/libti_dram.a
dram := $(or $(wildcard $(dram_library)),$(engine)/obj/no_dram.o)

# Without -fno-dfg and -fno-table the instances of a unit would not share their code (sim.vlt).
VERILATOR_FLAGS := --cc --top-module $(top) --prefix V$(top) -O3 -fno-dfg -fno-table \
  --x-assign fast --x-initial unique -CFLAGS '-fPIC -fvisibility=hidden' $(if $(filter-out 0,$(ASSERT)),--assert,--no-assert) \
  $(if $(waves),--trace-fst --trace-structs)
MODEL_FLAGS := OPT_FAST=-O2 OPT_SLOW=-O0 OPT_GLOBAL=-O2
HARNESS_FLAGS := -std=c++20 -O2 -g1 -fPIC -fvisibility=hidden -Wall -Wextra -Werror -ffp-contract=off -MMD -MP \
  -Isw -Isim -Ibuild/sw/generated -I$(config) -I$(verilated) $(if $(waves),-DTI_WAVES)
verilator_root = $(shell sed -n 's/^VERILATOR_ROOT *= *//p' $(verilated)/V$(top).mk)
verilator_includes = -isystem $(verilator_root)/include -isystem $(verilator_root)/include/vltstd
LINK_FLAGS := -shared -Wl,-Bsymbolic -Wl,--exclude-libs,ALL
LIBRARIES := -lfmt -pthread -latomic $(if $(waves),-lz -llz4)

# The library that `ti` and the Python module load; it shows one symbol.
$(library): $(harness) $(dram) $(engine)/dram $(verilated)/stamp build/sw/libti_sw.a
	@scripts/logged.sh $(engine)/link.log "build: $@" $(cxx) $(LINK_FLAGS) -o $@.part $(harness) $(dram) \
	  $(verilated)/libV$(top).a $(verilated)/libverilated.a build/sw/libti_sw.a $(LIBRARIES)
	@mv $@.part $@

# A library with a DRAM and one without are linked anew from what there is.
$(engine)/dram: FORCE
	@[[ -f $@ && $(dram) == "$$(<$@)" ]] || printf '%s\n' $(dram) >$@

# With other flags or another compiler nothing that is there is of use.  Verilator would leave its
# files, and so their objects, alone as long as their text is the same.
flags := $(cxx) $(shell verilator --version) $(VERILATOR_FLAGS) $(MODEL_FLAGS) $(HARNESS_FLAGS) $(LINK_FLAGS) $(LIBRARIES)
$(engine)/flags: FORCE
	@[[ -f $@ && $(call q,flags) == "$$(<$@)" ]] || \
	  { rm -rf $(verilated) $(engine)/obj $(library) && printf '%s\n' $(call q,flags) >$@; }

$(verilated)/stamp: $(rtl_sources) $(config)/ti_config_pkg.sv $(config)/ti_config.svh $(config)/ti_count_pkg.sv sim/sim.mk $(engine)/flags
	@scripts/logged.sh $(engine)/verilate.log "build: Verilator ($(what))" verilator $(VERILATOR_FLAGS) \
	  --Mdir $(verilated) -I$(config) lint/verilator.vlt $(wildcard sim/sim.vlt) $(config)/ti_config_pkg.sv $(config)/ti_count_pkg.sv -f rtl/ti.f $(wildcard sim/*.sv)
	@scripts/logged.sh $(engine)/model.log "build: compile the RTL model ($(what))" \
	  $(MAKE) -C $(verilated) -f V$(top).mk $(MODEL_FLAGS) libV$(top).a libverilated.a
	@touch $@

$(engine)/obj/%.o: sim/%.cpp $(verilated)/stamp $(config)/ti_config.hpp $(config)/ti_counters.hpp
	@mkdir -p $(@D)
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(HARNESS_FLAGS) $(verilator_includes) -c $< -o $@
$(engine)/obj/no_dram.o: sim/dram/no_dram.cpp $(verilated)/stamp
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(HARNESS_FLAGS) -c $< -o $@
-include $(wildcard $(engine)/obj/*.d $(engine)/obj/*/*.d)

FORCE:
.PHONY: FORCE
