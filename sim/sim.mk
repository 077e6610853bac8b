# SPDX-License-Identifier: Apache-2.0
#
# Builds: the configuration, the C++ programs, and `ti` with the RTL as an engine.  Included by the
# Makefile; uses its `config`, `tag` and `cxx`.

rtl_build := build/$(tag)
verilated := $(rtl_build)/verilated
rtl_sources := $(wildcard rtl/*.sv rtl/*/*.sv rtl/*/*.svh rtl/*/*/*.sv) rtl/ti.f lint/verilator.vlt $(wildcard sim/sim.vlt sim/*.sv)
harness := $(patsubst sim/%.cpp,$(rtl_build)/obj/%.o,$(wildcard sim/*.cpp)) $(rtl_build)/obj/main.o

# Without -fno-dfg and -fno-table the instances of a unit would not share their code (sim.vlt).
VERILATOR_FLAGS := --cc --top-module ti_engine --prefix Vti_engine -O3 -fno-dfg -fno-table \
  --x-assign fast --x-initial unique $(if $(filter-out 0,$(ASSERT)),--assert,--no-assert)
HARNESS_FLAGS = -std=c++20 -O2 -g1 -Wall -Wextra -Werror -ffp-contract=off -MMD -MP \
  -Isw -Isim -I$(config) -I$(verilated) -isystem $(verilator_root)/include -isystem $(verilator_root)/include/vltstd
verilator_root = $(shell sed -n 's/^VERILATOR_ROOT *= *//p' $(verilated)/Vti_engine.mk)
LIBRARIES = $(if $(wildcard /usr/include/embree4),-lembree4,-lembree3) \
  -lassimp -lfmt -ltbb -lzstd -lz -lgmpxx -lgmp -pthread -latomic

# Always run; rewrites only what changes, so that nothing is rebuilt without need.
$(config)/config.json: FORCE | build/setup.stamp
	@python scripts/configure.py $(CONFIG) $(SET) --out $(config)
$(config)/ti_config_pkg.sv $(config)/ti_config.hpp $(config)/ti_count_pkg.sv $(config)/ti_counters.hpp: $(config)/config.json ;

# --- C++ programs, by CMake ---------------------------------------------------------------------

build/sw/build.ninja: sw/CMakeLists.txt build/setup.stamp
	@scripts/logged.sh build/sw.log "build: configure C++" cmake -S sw -B build/sw -G Ninja \
	  -DCMAKE_CXX_COMPILER=$(cxx) -DTI_PYTHON=$(CURDIR)/build/venv/bin/python
	@touch $@

# ninja_build TARGETS: builds them, one make at a time.
ninja_build = exec 9>build/sw/lock && flock 9 && \
  scripts/logged.sh build/sw/build.log "build: C++ ($(1))" ninja -C build/sw -j $(jobs) $(1)

sw: build/sw/build.ninja
	@$(call ninja_build,all)
model: build/sw/build.ninja
	@$(call ninja_build,ti_model)
# GCC brings its own sanitizers; clang's would be one more package.
sanitized: build/setup.stamp FORCE
	@exec 9>build/sanitize.lock && flock 9 && scripts/logged.sh build/sanitize.log "build: C++ with sanitizers" \
	  sh -c 'cmake -S sw -B build/sanitize -G Ninja -DCMAKE_CXX_COMPILER=g++ -DTI_SANITIZE=ON && \
	    ninja -C build/sanitize -j $(jobs) ti_tests'
build/sw/ti: build/sw/build.ninja FORCE
	@$(call ninja_build,ti)
build/sw/libti_sw.a: build/sw/build.ninja FORCE
	@$(call ninja_build,ti_sw)

# --- ti with the RTL ----------------------------------------------------------------------------

$(verilated)/stamp: $(rtl_sources) $(config)/ti_config_pkg.sv $(config)/ti_count_pkg.sv sim/sim.mk build/setup.stamp
	@scripts/logged.sh $(rtl_build)/verilate.log "build: Verilator ($(tag))" verilator $(VERILATOR_FLAGS) \
	  --Mdir $(verilated) lint/verilator.vlt $(wildcard sim/sim.vlt) $(config)/ti_config_pkg.sv $(config)/ti_count_pkg.sv -f rtl/ti.f $(wildcard sim/*.sv)
	@scripts/logged.sh $(rtl_build)/model.log "build: compile the RTL model ($(tag))" \
	  $(MAKE) -j $(jobs) -C $(verilated) -f Vti_engine.mk OPT_FAST=-O2 OPT_SLOW=-O0 OPT_GLOBAL=-O2 \
	  libVti_engine.a libverilated.a
	@touch $@

$(rtl_build)/obj/%.o: sim/%.cpp $(verilated)/stamp $(config)/ti_config.hpp $(config)/ti_counters.hpp
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(HARNESS_FLAGS) -c $< -o $@
$(rtl_build)/obj/main.o: sw/cli/main.cpp build/setup.stamp
	@scripts/logged.sh $@.log "build: $<" ccache $(cxx) $(HARNESS_FLAGS) -c $< -o $@
-include $(wildcard $(rtl_build)/obj/*.d)

$(rtl_build)/ti: $(harness) $(verilated)/stamp build/sw/libti_sw.a
	@scripts/logged.sh $(rtl_build)/link.log "build: $@" $(cxx) -o $@ $(harness) \
	  $(verilated)/libVti_engine.a $(verilated)/libverilated.a build/sw/libti_sw.a $(LIBRARIES)

engine: $(rtl_build)/ti ## Build ti with the RTL of CONFIG=

.PHONY: sw model sanitized engine
