# SPDX-License-Identifier: Apache-2.0
#
# The only door to the project.  `make` alone prints what there is.

CONFIG ?= small
SET ?=
SCENE ?= cornell
SIZE ?= 256x256
SPP ?= 1
EFFECTS ?= none
ENGINE ?= rtl
FORMAT ?= 8,23
FILE ?=
OP ?=
OUT ?=
RAYS ?=
IMAGE ?=
SEED ?=
RAY_WAVES ?=
LOG_RAY ?=
MEM_LATENCY ?=
MEM_BANDWIDTH ?=
LIMIT ?=
TEST ?=
UNIT ?=
QUICK ?=

SHELL := /bin/bash
MAKEFLAGS += --no-print-directory
.SUFFIXES:
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:

export PATH := $(CURDIR)/build/venv/bin:$(PATH)
export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
export CCACHE_DIR ?= $(CURDIR)/build/ccache
export OBJCACHE := ccache

jobs := $(shell nproc)
# The compiler that the set-up chose; read when a recipe runs.
cxx = $(shell sed -n 1p build/setup.stamp)

empty :=
space := $(empty) $(empty)
comma := ,
# Name of the configuration with its overrides, as a folder: small-num_trv-2.
tag := $(subst =,-,$(subst $(space),-,$(strip $(basename $(notdir $(CONFIG))) $(SET))))
config := build/$(tag)/config

# A bare scene name is looked up, with or without its ending; anything else is a path.
scene_folders := scenes build/scenes ../shared/scenes
scene_endings := .gltf .glb .obj .ply .ply.zst
knot := build/scenes/knot.ply
scene = $(firstword $(if $(filter knot,$(SCENE)),$(knot)) $(wildcard $(foreach d,$(scene_folders),\
  $(addprefix $(d)/$(SCENE),$(scene_endings)) $(filter-out $(d)/,$(d)/$(filter-out .. .,$(SCENE))))) $(SCENE))
scene_name = $(firstword $(subst ., ,$(notdir $(scene))))
run_name = $(scene_name)-$(tag)$(if $(filter-out rtl,$(ENGINE)),-$(ENGINE))

# What an engine needs beside the program: the RTL is a library for a configuration.
ti := build/sw/ti
library = $(if $(filter rtl,$(1)),$(rtl_library))
needs = check-engine $(config)/config.json $(ti) $(call library,$(ENGINE)) $(filter $(knot),$(scene))
common_args = --config $(config)/config.json --engine $(ENGINE) $(addprefix --rtl ,$(call library,$(ENGINE))) \
  $(if $(RAY_WAVES),--waves $(RAY_WAVES)) $(if $(SEED),--seed $(SEED)) $(if $(IMAGE),--image $(IMAGE)) \
  $(if $(LOG_RAY),--log-ray $(LOG_RAY)) \
  $(if $(MEM_LATENCY),--mem-latency $(MEM_LATENCY)) $(if $(MEM_BANDWIDTH),--mem-bytes-per-cycle $(MEM_BANDWIDTH))
# Hard cases run on both unless the user names one.
case_engines := $(if $(filter file,$(origin ENGINE)),model rtl,$(ENGINE))
# Of the package in scripts/extra-packages.txt.
liberty := /usr/share/qflow/tech/osu018/osu018_stdcells.lib
cases = $(or $(FILE),scenes/hardcases.jsonl)

include sim/sim.mk

##@ Trace
render: $(needs) ## Picture of SCENE= on the RTL (SIZE= SPP= EFFECTS= CONFIG= ENGINE= MEM_LATENCY= MEM_BANDWIDTH= OUT= DUMP=1)
	@$(ti) render --scene $(scene) --size $(SIZE) --spp $(SPP) --effects $(EFFECTS) $(common_args) \
	  $(if $(filter-out 0,$(DUMP)),--dump) --out $(or $(OUT),build/render/$(run_name))

trace: need-RAYS $(needs) ## Hits of rays, yours or made (RAYS=file.npy or random:1000, primary:, ao:, ... RAY_WAVES=10 LOG_RAY=17 SCENE= CONFIG= ENGINE= OUT=)
	@$(ti) trace --rays $(RAYS) --scene $(scene) $(common_args) \
	  --out $(or $(OUT),build/trace/$(run_name))

image: $(config)/config.json build/sw/ti $(filter $(knot),$(scene)) ## Memory image of SCENE= (CONFIG= OUT=), for IMAGE= of render and trace
	@build/sw/ti image --scene $(scene) --config $(config)/config.json --out $(or $(OUT),build/image/$(scene_name)-$(tag).tiim)

hardcases: check-engine $(config)/config.json $(ti) $(foreach e,$(case_engines),$(call library,$(e))) ## Hard cases on model and RTL (FILE= CONFIG= ENGINE=)
	@$(foreach e,$(case_engines),$(ti) hardcases --file $(cases) \
	  --config $(config)/config.json --engine $(e) $(addprefix --rtl ,$(call library,$(e))) &&) true

testfloat: need-FILE need-OP check-format build/setup.stamp ## Lines of Berkeley TestFloat on an operator (OP=add FORMAT=8,23 FILE=)
	@scripts/logged.sh build/fp/$(subst $(comma),-,$(FORMAT))/build.log "build: FP operators ($(FORMAT))" \
	  env CXX=$(cxx) scripts/build_fp_rtl.sh $(subst $(comma), ,$(FORMAT)) build/fp/$(subst $(comma),-,$(FORMAT))
	@build/fp/$(subst $(comma),-,$(FORMAT))/fp_rtl --testfloat $(FILE) --op $(OP)

##@ Check
test: build/setup.stamp ## Every check that CI runs (TEST=part_of_a_name for a few)
	@scripts/test.sh '$(TEST)'

sim: check-unit model ## cocotb tests of one module (UNIT=ti_fifo TEST=part SEED= WAVES=1)
	@pytest -s tb/unit/test_$(UNIT).py

waves: check-unit model ## The same with an FST, opened in a viewer (UNIT= TEST=)
	@WAVES=1 pytest tb/unit/test_$(UNIT).py; status=$$?; scripts/show_waves.sh $(UNIT); exit $$status

operators: $(config)/config.json ## FP operators and memory bits of CONFIG= beside the published core (OUT=file.json)
	@python scripts/operators.py $(config) $(if $(OUT),--json $(OUT))

synth: $(config)/config.json ## Latches, loops, memories and cells of CONFIG= by Yosys (UNIT=ti_fp_add OUT=file.json)
	@python scripts/synth_check.py $(config) $(if $(UNIT),--unit $(UNIT)) $(if $(OUT),--json $(OUT))

mutants: sw $(knot) ## Faults put into a copy of the RTL: the tests must find each (TEST=part_of_a_name QUICK=1 ALL=1)
	@python scripts/mutants.py $(if $(TEST),--only '$(TEST)') $(if $(filter-out 0,$(QUICK)),--quick) $(if $(filter-out 0,$(ALL)),--every-check)

timing: $(config)/config.json ## Longest path, gates and flops of CONFIG= in 0.18 um (UNIT=ti_fp_add LIMIT=6.5 OUT=file.json)
	@[[ -f $(liberty) ]] || scripts/setup.sh --extra
	@python scripts/timing.py $(config) $(if $(UNIT),--unit $(UNIT)) $(if $(LIMIT),--limit $(LIMIT)) $(if $(OUT),--json $(OUT))

lint: build/setup.stamp ## Verilator -Wall, Verible, clang-format, Ruff
	@scripts/lint.sh

format: build/setup.stamp ## Lay out RTL, C++ and Python
	@verible-verilog-format --flagfile=lint/verible-format.flags --inplace $$(find rtl tb sim -name '*.sv')
	@clang-format -i $$(find sw sim tb -name '*.cpp' -o -name '*.hpp')
	@ruff format --quiet && ruff check --quiet --fix

fp-volume: sw ## C++ FP operators against MPFR, small formats in full (PAIRS=10000000 of the others)
	@build/sw/fp_volume --pairs $(or $(PAIRS),10000000) --seed $(or $(SEED),1)

tree-table: build/sw/ti $(config)/config.json ## Tree statistics of the papers' scenes beside the published ones
	@python scripts/tree_table.py build/sw/ti $(config)/config.json $(or $(SCENES),../shared/scenes)

##@ House
setup: ## Install what is missing (apt, Python in build/venv)
	@scripts/setup.sh

clean: ## Remove what builds and runs wrote; the set-up stays (ALL=1: that too)
	@$(if $(ALL),rm -rf build,find build -mindepth 1 -maxdepth 1 ! -name venv ! -name ccache ! -name setup.stamp -exec rm -rf {} +)

help: ## Show this list
	@awk 'BEGIN {FS = ":.*## "} /^##@ / {printf "\n%s\n", substr($$0, 5)} \
	  /^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile
	@printf '\nCONFIG= is a name in configs/ or a file; SET="num_trv=2 trv_slots=16" changes keys of it.\n'

need-%:
	@[[ -n "$($*)" ]] || { echo "make $(firstword $(MAKECMDGOALS)): $*= is missing; 'make help' says what it is" >&2; exit 2; }

check-engine:
	@[[ " rtl model embree " == *" $(ENGINE) "* ]] || \
	  { echo "ENGINE=$(ENGINE): no such engine; there are rtl, model and embree" >&2; exit 2; }

check-unit: need-UNIT
	@[[ -f tb/unit/test_$(UNIT).py ]] || { echo "UNIT=$(UNIT): there is no tb/unit/test_$(UNIT).py; there are" \
	  $(sort $(patsubst tb/unit/test_%.py,%,$(wildcard tb/unit/test_*.py))) >&2; exit 2; }

check-format:
	@[[ "$(FORMAT)" =~ ^[3-8],([2-9]|1[0-9]|2[0-3])$$ ]] || \
	  { echo "FORMAT=$(FORMAT): not E,M with E from 3 to 8 and M from 2 to 23, as in 8,23" >&2; exit 2; }

# Also when this folder has moved, since Python environments hold its path.
build/setup.stamp: scripts/setup.sh scripts/repair_verilator.py scripts/apt-packages.txt requirements.txt \
    $(if $(filter-out $(shell sed -n 2p build/setup.stamp 2>/dev/null),$(CURDIR)),FORCE)
	@scripts/setup.sh

# The large scene of the project.
$(knot): scripts/make_scenes.py | build/setup.stamp
	@python scripts/make_scenes.py --big $(@D)

FORCE:
.PHONY: FORCE operators synth timing mutants tree-table render trace image hardcases testfloat test sim waves lint format setup clean help check-engine check-unit check-format
