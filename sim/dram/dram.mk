# SPDX-License-Identifier: Apache-2.0
#
# Builds the DRAM of MEM=dram, DRAMsim3 with our binding, as build/dram/libti_dram.a, and its tests, build/dram/dram_tests.
# The sources of DRAMsim3 are where `scripts/setup.sh --dram` puts them. Run by scripts/build_dram.sh, in the environment of
# the Makefile.

SHELL := /bin/bash
MAKEFLAGS += --no-print-directory
.SUFFIXES:
.DELETE_ON_ERROR:

out := build/dram
source := $(out)/dramsim3/DRAMsim3
cxx := $(shell sed -n 1p build/setup.stamp)
parts := bankstate channel_state command_queue common configuration controller refresh timing
objects := $(patsubst %,$(out)/obj/%.o,$(parts) dram_memory)
# Of DRAMsim3 itself no warnings.
FLAGS := -std=c++20 -O2 -g1 -fPIC -fvisibility=hidden -MMD -MP -Isw -Isim -I$(out) -isystem $(source)/src -isystem $(source)/ext/headers
THEIRS := -w -include sim/dram/simple_stats.hpp
OURS := -Wall -Wextra -Werror -include sim/dram/simple_stats.hpp

# Answers of one compiler with one set of flags.
flags := $(cxx) $(FLAGS) $(THEIRS) $(OURS)
$(out)/flags: FORCE
	@[[ -f $@ && '$(flags)' == "$$(<$@)" ]] || { rm -rf $(out)/obj && mkdir -p $(out)/obj && printf '%s\n' '$(flags)' >$@; }

$(out)/libti_dram.a: $(objects)
	@rm -f $@ && ar rcs $@.part $^ && mv $@.part $@

$(out)/gddr3.inc: sim/dram/gddr3.ini $(out)/flags
	@{ printf 'R"ini('; cat $<; printf ')ini"\n'; } >$@

$(out)/obj/%.o: $(source)/src/%.cc $(out)/flags
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(FLAGS) $(THEIRS) -c $< -o $@
$(out)/obj/dram_memory.o: sim/dram/dram_memory.cpp $(out)/gddr3.inc $(out)/flags
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(FLAGS) $(OURS) -c $< -o $@

$(out)/obj/test_dram.o: sim/dram/test_dram.cpp $(out)/flags
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(FLAGS) -Wall -Wextra -Werror -c $< -o $@
$(out)/obj/main.o: sw/test/main.cpp $(out)/flags
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(FLAGS) -O0 -c $< -o $@
$(out)/dram_tests: $(out)/obj/test_dram.o $(out)/obj/main.o $(out)/libti_dram.a
	@scripts/logged.sh $(out)/link.log "build: $@" $(cxx) -o $@ $^ -lfmt
-include $(wildcard $(out)/obj/*.d)

FORCE:
.PHONY: FORCE
