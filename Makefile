# SPDX-License-Identifier: Apache-2.0
#
# The only door to the project.  `make` alone prints what there is.

CONFIG ?= small
BASE ?= small
SET ?=
SCENE ?= cornell
SIZE ?= 256x256
SPP ?= 1
EFFECTS ?= auto
BOUNCES ?= 4
FRAMES ?=
FPS ?=
ENGINE ?= rtl
FORMAT ?= 8,23
FILE ?=
OP ?=
OUT ?=
RAYS ?=
IMAGE ?=
SEED ?=
GENERATED ?=
RAY_WAVES ?=
LOG_RAY ?=
MEM ?=
MEM_LATENCY ?=
MEM_BANDWIDTH ?=
SCENES ?=
CORES ?=
N ?=
VARIANTS ?=
LIMIT ?=
PART ?=
SEEDS ?=
SPEED ?=
BASELINE ?=
REASON ?=
TEST ?=
UNIT ?=
QUICK ?=
ID ?=
HOURS ?=
ROUND ?=
IMAGES ?=
FORMATS ?=
TESTS ?=
TRAVERSALS ?=
RTL ?=
SCHEDULER ?=
WAVES ?=
RUNS ?=
BOARD ?=
MODE ?= ooc
TOP ?=
SOURCES ?=

SHELL := /bin/bash
MAKEFLAGS += --no-print-directory
.SUFFIXES:
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:

export PATH := $(CURDIR)/build/venv/bin:$(PATH)
# Compiled Python is kept in build/, also where the environment says to keep none: each simulation loads it.
unexport PYTHONDONTWRITEBYTECODE
export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
export CCACHE_DIR ?= $(CURDIR)/build/ccache
export CCACHE_SLOPPINESS := pch_defines,time_macros
export OBJCACHE := ccache

empty :=
space := $(empty) $(empty)
comma := ,
$(if $(findstring $(space),$(CURDIR)),$(error The path '$(CURDIR)' has a space, which the makefiles of \
  Verilator cannot hold: move this checkout))

# q NAME: the value of a variable as one word of the shell, whatever is in it.
q = '$(subst ','\'',$(value $(1)))'
# opt OPTION,NAME: the option with that value; nothing when it is empty.
opt = $(if $(value $(2)),$(1) $(call q,$(2)))
# out DEFAULT: OUT= as one word, or the default.
out = $(if $(value OUT),$(call q,OUT),$(1))

# Folders of the configuration and of its engine: one call of Python, when a recipe first asks.
overrides = $(foreach word,$(value SET) $(if $(value CORES),cores=$(value CORES)),'$(subst ','\'',$(word))')
find_folders = $(shell PATH=$(call q,PATH) env -u PYTHONDONTWRITEBYTECODE PYTHONPYCACHEPREFIX=build/pycache \
  python scripts/configure.py --build build -- $(call q,CONFIG) $(overrides))
folders = $(eval folders := $$(find_folders))$(folders)
config = $(word 1,$(folders))
engine = $(word 2,$(folders))

# What an engine needs beside the program: the RTL is a library for a configuration.
ti := build/sw/ti
library = $(if $(filter rtl,$(1)),engine)$(if $(filter top,$(1)),top-engine)
rtl = $(if $(filter rtl,$(1)),--rtl $(engine)/libti_rtl.so)$(if $(filter top,$(1)),--rtl $(engine)/top/libti_rtl.so)$(if $(filter board,$(1)),--board $(call q,BOARD))
# Scenes that are made when they are asked for: made NAMES are their files.
knot := build/scenes/knot.ply
gallery_names := cornell_glass pavilion still_life windmill
closed_names := icosphere torus tube
made_files := $(knot) $(closed_names:%=build/scenes/%.ply) $(gallery_names:%=build/scenes/%.gltf)
made = $(filter $(made_files),$(foreach s,$(1),$(if $(filter knot $(closed_names),$(s)),build/scenes/$(s).ply,$(if $(filter $(gallery_names),$(s)),build/scenes/$(s).gltf,$(s)))))
needs = check-engine check-mem $(if $(filter board,$(ENGINE)),need-BOARD) config $(ti) $(call library,$(ENGINE)) $(call made,$(value SCENE))
scene = "$$(scripts/scene.sh file $(call q,SCENE))"
# What a run is called: cornell-small, cornell-small-num_trv-2-model.
scene_name = "$$(scripts/scene.sh name $(scene))"-$(notdir $(config))
run_name = $(scene_name)$(if $(filter-out rtl,$(ENGINE)),-$(ENGINE))
common_args = --config $(config)/config.json --engine $(ENGINE:top=rtl) --scene $(scene) \
  $(call rtl,$(ENGINE)) $(call opt,--waves,RAY_WAVES) $(call opt,--seed,SEED) $(call opt,--image,IMAGE) $(call opt,--log-ray,LOG_RAY) \
  $(memory)
picture_args = --size $(call q,SIZE) --spp $(call q,SPP) --effects $(call q,EFFECTS) --bounces $(call q,BOUNCES) \
  $(call opt,--frames,FRAMES) $(call opt,--fps,FPS)
# CONFIG=auto: BASE= with the keys that the picture calls for, then those of SET=.
auto := $(filter auto,$(value CONFIG))
render_auto = $(MAKE) machine CONFIG=$(call q,BASE) KEYS=build/auto/$$$$ && { read -r keys; read -r base; } <build/auto/$$$$ && \
  rm build/auto/$$$$ && $(MAKE) render CONFIG=$(call q,BASE) SET="$$keys "$(call q,SET) PLANNED_ON="$$base" \
  OUT=$(call out,build/render/"$$(scripts/scene.sh name $(scene))-auto-$$(basename "$$(dirname "$$base")")"$(if $(filter-out rtl,$(ENGINE)),-$(ENGINE)))
# The memory behind the ports: its kind, or latency,bytes of a fixed one, which also have variables of their own.
mem_pair := $(findstring $(comma),$(value MEM))
mem_latency := $(if $(mem_pair),$(word 1,$(subst $(comma), ,$(value MEM))),$(value MEM_LATENCY))
mem_bytes := $(if $(mem_pair),$(word 2,$(subst $(comma), ,$(value MEM))),$(value MEM_BANDWIDTH))
memory = $(if $(mem_pair),,$(call opt,--mem,MEM)) $(call opt,--mem-latency,mem_latency) $(call opt,--mem-bytes-per-cycle,mem_bytes)
# What is measured unless SCENES= says it: the papers' scenes, or ours where those are not.
papers_scenes := $(foreach s,conference sibenik crytek_sponza,$(if $(wildcard ../shared/scenes/$(s).ply.zst),$(s)))
bench_scenes = $(or $(value SCENES),$(papers_scenes),cornell knot)
# The same of pictures.
gallery_scenes = $(or $(value SCENES),cornell cornell_glass pavilion knot still_life windmill)
effects_scenes = $(or $(value SCENES),$(foreach s,cornell_box cornell_box_mirror cornell_box_sphere cornell_box_water sibenik crytek_sponza \
  bart_kitchen bart_museum bart_robots conference,$(if $(wildcard ../shared/scenes/$(s).ply.zst),$(s))) cornell knot $(gallery_names))
accuracy_scenes = $(or $(value SCENES),$(closed_names))
# A scene there may be moved, icosphere@1e6: its name, and the rest.
unmoved = $(foreach s,$(1),$(firstword $(subst @, ,$(s))))
moved = $(if $(findstring @,$(1)),@$(lastword $(subst @, ,$(1))))
fidelity_scenes = $(or $(value SCENES),cornell knot)
convergence_scenes = $(or $(value SCENES),cornell cornell_glass pavilion still_life)
# Hard cases run on both unless the user names one.
case_engines := $(if $(filter file,$(origin ENGINE)),model rtl,$(ENGINE))
cases = $(if $(value FILE),$(call q,FILE),scenes/hardcases.jsonl)
case_waves = $(filter-out 0,$(value WAVES))
case_out = $(call out,build/hardcase/$(value ID))
case_engine = $(if $(case_waves),$(waves_engine),$(engine))
# A library that writes waves has a folder of its own, and is built when it is asked for.
waves_engine = build/waves/$(notdir $(engine))
# Of the package in scripts/extra-packages.txt.
liberty := /usr/share/qflow/tech/osu018/osu018_stdcells.lib

##@ Trace
render: $(if $(auto),check-engine check-mem,$(needs)) ## Picture of SCENE= on the RTL (SIZE= SPP= EFFECTS=auto|all|none|auto-mirror BOUNCES= FRAMES=0:16 CONFIG=auto|small CORES= ENGINE=rtl|top|board|model|embree BOARD=board.json MEM=ideal|fixed|dram OUT= DUMP=1)
	@$(if $(auto),$(render_auto),$(ti) render $(picture_args) $(common_args) $(call opt,--base,PLANNED_ON) \
	  $(if $(filter-out 0,$(DUMP)),--dump) --out $(call out,build/render/$(run_name)))

trace: need-RAYS $(needs) ## Hits of rays, yours or made (RAYS=file.npy or random:1000, primary:, ao:, ... RAY_WAVES=10 LOG_RAY=17 SCENE= CONFIG= ENGINE= MEM= OUT=)
	@$(ti) trace --rays $(call q,RAYS) $(common_args) \
	  --out $(call out,build/trace/$(run_name)-"$$(scripts/scene.sh rays $(call q,RAYS))")

bench: check-mem engine sw $(call made,$(bench_scenes)) ## Mrays/s of scenes and kinds of rays, into bench.json (SCENES="..." RAYS="primary ao diffuse" CONFIG= CORES= MEM=ideal|fixed|dram N= SIZE= OUT=)
	@python scripts/bench.py --config $(config)/config.json --library $(engine)/libti_rtl.so \
	  $(bench_options) --out $(call out,build/bench/$(notdir $(config)))
bench compare: bench_options = $(memory) --scene $(foreach s,$(bench_scenes),"$$(scripts/scene.sh file '$(subst ','\'',$(s))')") \
  $(if $(value RAYS),--rays $(foreach r,$(value RAYS),'$(subst ','\'',$(r))')) $(call opt,--count,N) \
  $(if $(filter file,$(origin SIZE)),,--frame $(call q,SIZE))

compare: need-VARIANTS check-mem build/setup.stamp sw $(call made,$(bench_scenes)) ## A bench for each variant, side by side (VARIANTS="layout=dfl; stack_depth=0 trv_slots=8" and the words of bench)
	@python scripts/compare.py --config $(call q,CONFIG) $(call opt,--set,SET) $(call opt,--cores,CORES) \
	  --variants $(call q,VARIANTS) $(bench_options) --out $(call out,build/compare/$(notdir $(config)))

gallery: check-engine $(if $(filter board,$(ENGINE)),no-host) check-mem config $(ti) $(call library,$(ENGINE)) $(call made,$(gallery_scenes)) ## Pictures of scenes with plan, rays, cycles and time on one page (SCENES="..." SIZE= SPP= and other words of render)
	@python scripts/gallery.py $(foreach w,$(gallery_words),$(if $(value $(w)),$(w)=$(call q,$(w)))) \
	  --out $(call out,build/gallery/$(notdir $(config))) --scene $(foreach s,$(gallery_scenes),'$(subst ','\'',$(s))')
gallery: SIZE := $(if $(filter file,$(origin SIZE)),320x240,$(value SIZE))
gallery: SPP := $(if $(filter file,$(origin SPP)),4,$(value SPP))
gallery_words := CONFIG SET CORES ENGINE MEM MEM_LATENCY MEM_BANDWIDTH SIZE SPP EFFECTS BOUNCES SEED

image: config build/sw/ti $(call made,$(value SCENE)) ## Memory image of SCENE= (CONFIG= OUT=), for IMAGE= of render and trace
	@build/sw/ti image --scene $(scene) --config $(config)/config.json --out $(call out,build/image/$(scene_name).tiim)

hardcases: check-engine no-host config $(ti) $(foreach e,$(case_engines),$(call library,$(e))) $(call made,icosphere) ## Hard cases and rays in volume in each format and test, a table; and those of CONFIG= on model and RTL (FORMATS="8,23 7,16" TESTS="local woop" N=100000 FILE= CONFIG= ENGINE= SEED= OUT=)
	@status=0; $(ti) ladder --file $(cases) --config $(config)/config.json --scene build/scenes/icosphere.ply \
	  $(call opt,--formats,FORMATS) $(call opt,--tests,TESTS) $(call opt,--seed,SEED) --count $(or $(call opt,,N),5000) \
	  --out $(call out,build/hardcases) || status=$$?; [[ $$status -lt 2 ]] || exit $$status; \
	for engine in $(case_engines); do echo; echo "$(notdir $(config)), $$engine:"; $(ti) hardcases --file $(cases) \
	  --config $(config)/config.json --engine $$engine $(if $(filter rtl,$(case_engines)),--rtl $(engine)/libti_rtl.so) || status=$$?; done; exit $$status

hardcase: need-ID check-engine no-host config $(ti) $(foreach e,$(case_engines),$(if $(case_waves),$(if $(filter rtl,$(e)),waves-engine),$(call library,$(e)))) ## One of them, with its steps from model and RTL (ID= FILE= CONFIG= ENGINE= WAVES=1 OUT=)
	@status=0; $(foreach e,$(case_engines),$(ti) hardcases --file $(cases) --config $(config)/config.json --engine $(e) \
	  --id $(call q,ID) --out $(case_out) $(if $(filter rtl,$(e)),--rtl $(case_engine)/libti_rtl.so \
	  $(if $(case_waves),--waves-file $(case_out)/ray-0.fst)) || status=$$?; [[ $$status -lt 2 ]] || exit $$status;) \
	$(if $(case_waves),$(if $(filter rtl,$(case_engines)),scripts/show_waves.sh ti_engine $(case_out)/ray-0.fst $(engine)/config;)) exit $$status

waves-engine: config build/sw/libti_sw.a
	@mkdir -p $(waves_engine)
	@scripts/build_engine.sh $(waves_engine) $(MAKE) config=$(engine)/config waves=1 what="$(notdir $(config)), waves" $(if $(findstring jobserver,$(MAKEFLAGS)),,-j $(jobs))

faults: check-engine no-host config $(ti) $(call library,$(ENGINE)) $(call made,$(value SCENE)) ## Rays on damaged copies of the scene's image, RTL beside model: what ends how (IMAGES=1000 RAYS=inside:32 SEED= SCENE= CONFIG= SET="addr_bits=33 watchdog_steps=1000" ENGINE=rtl|model OUT=)
	@$(ti) faults --images $(if $(value IMAGES),$(call q,IMAGES),1000) --rays $(if $(value RAYS),$(call q,RAYS),inside:32) \
	  --config $(config)/config.json --engine $(ENGINE) --scene $(scene) $(call rtl,$(ENGINE)) $(call opt,--seed,SEED) $(memory) \
	  --out $(call out,build/faults/$(run_name))
# A walk in a circle ends at the watchdog, soon; and no node number reaches around all addresses.
faults: SET := $(or $(value SET),addr_bits=33 watchdog_steps=1000)

testfloat: need-FILE need-OP check-format build/setup.stamp ## Lines of Berkeley TestFloat on an operator (OP=add FORMAT=8,23 FILE=)
	@scripts/logged.sh build/fp/$(fp)/build.log "build: FP operators ($(FORMAT))" \
	  env CXX=$(cxx) scripts/build_fp_rtl.sh $(subst $(comma), ,$(FORMAT)) build/fp/$(fp)
	@build/fp/$(fp)/fp_rtl --testfloat $(call q,FILE) --op $(call q,OP)
testfloat: fp = $(subst $(comma),-,$(FORMAT))

machine: need-KEYS config $(ti) $(call made,$(value SCENE))
	@mkdir -p $(dir $(KEYS)) && $(ti) machine $(picture_args) $(common_args) --out $(KEYS) && echo $(config)/config.json >>$(KEYS)

##@ Beside others
effects-table: check-engine no-host config $(ti) $(call library,$(ENGINE)) $(call made,$(effects_scenes)) ## EFFECTS=auto beside all: rays, cycles, seconds, the same bits (SCENES="..." SIZE= SPP= BOUNCES= CONFIG= ENGINE=rtl|model OUT=)
	@python scripts/effects_table.py --config $(config)/config.json $(if $(filter rtl,$(ENGINE)),--library $(engine)/libti_rtl.so) \
	  $(if $(filter file,$(origin SIZE)),,--size $(call q,SIZE)) --spp $(call q,SPP) --bounces $(call q,BOUNCES) \
	  --out $(call out,build/effects/$(notdir $(config))) --scene $(foreach s,$(effects_scenes),'$(subst ','\'',$(s))')

second-opinion: config $(ti) build/setup.stamp ## Three scenes beside Mitsuba 3, converged (OUT=)
	@scripts/setup.sh --checks
	@build/checks/bin/python scripts/second_opinion.py --config $(config)/config.json --out $(call out,build/second-opinion)

convergence: config $(ti) $(call made,$(convergence_scenes)) ## Noise by samples a pixel, and each effect alone beside Embree (SCENES="..." OUT=)
	@scripts/setup.sh --checks
	@build/checks/bin/python scripts/convergence.py --config $(config)/config.json --out $(call out,build/convergence) \
	  --scene $(foreach s,$(convergence_scenes),'$(subst ','\'',$(s))')

accuracy: build/setup.stamp build/sw/ti $(call made,$(call unmoved,$(accuracy_scenes))) ## Wrong hits and pixels of formats, tests and walks by exact arithmetic, beside their cost: JSON lines, CSV, a page (SCENES="conference torus@1e6" FORMATS="8,23 7,16" TESTS="local woop" TRAVERSALS= RAYS="edges far" N= WORK= SIZE= RTL=20000 QUICK=1 SCHEDULER=tcp://...|slurm:jobs=8 CONFIG= SEED= OUT=)
	@scripts/setup.sh --checks
	@build/checks/bin/python scripts/accuracy.py --ti build/sw/ti --config $(call q,CONFIG) $(call opt,--formats,FORMATS) \
	  $(call opt,--tests,TESTS) $(call opt,--traversals,TRAVERSALS) $(call opt,--rays,RAYS) $(call opt,--seed,SEED) \
	  --count $(or $(call opt,,N),$(if $(value QUICK),2000,100000)) --work $(or $(call opt,,WORK),$(if $(value QUICK),2e6,1e8)) \
	  --size $(if $(filter file,$(origin SIZE)),$(if $(value QUICK),80x60,320x240),$(call q,SIZE)) $(call opt,--rtl,RTL) $(call opt,--scheduler,SCHEDULER) \
	  --out $(call out,build/accuracy/sweep) \
	  --scene $(foreach s,$(accuracy_scenes),"$$(scripts/scene.sh file '$(subst ','\'',$(call unmoved,$(s)))')"'$(subst ','\'',$(call moved,$(s)))')

fidelity: config sw $(call made,$(fidelity_scenes)) ## Error of Mrays/s of model, memories and samples beside the seconds they take, on one plot (SCENES="..." RAYS="primary ao diffuse" N="1/64 1/16 1/4" RUNS= SIZE= MEM="ideal fixed dram" CONFIG= SET= CORES= OUT=)
	@python scripts/fidelity.py --config $(call q,CONFIG) $(call opt,--set,SET) $(call opt,--cores,CORES) \
	  $(if $(value RAYS),--rays $(foreach r,$(value RAYS),'$(subst ','\'',$(r))')) $(call opt,--shares,N) $(call opt,--runs,RUNS) \
	  $(if $(filter file,$(origin SIZE)),,--frame $(call q,SIZE)) $(memory) --out $(call out,build/fidelity/$(notdir $(config))) \
	  --scene $(foreach s,$(fidelity_scenes),"$$(scripts/scene.sh file '$(subst ','\'',$(s))')")

##@ Build
engine: config build/sw/libti_sw.a $(if $(filter dram,$(value MEM)),dram) ## The RTL of CONFIG= as a library that ti and Python load (SET= MEM=dram)
	@[[ ! -d build/dram/dramsim3 ]] || scripts/build_dram.sh $(MAKE) libti_dram.a
	@scripts/build_engine.sh $(engine) $(MAKE) what=$(notdir $(config)) $(if $(findstring jobserver,$(MAKEFLAGS)),,-j $(jobs))

# The same behind registers and streams, driven as a host drives a board.
top-engine: config build/sw/libti_sw.a $(if $(filter dram,$(value MEM)),dram)
	@mkdir -p $(engine)/top
	@[[ ! -d build/dram/dramsim3 ]] || scripts/build_dram.sh $(MAKE) libti_dram.a
	@scripts/build_engine.sh $(engine)/top $(MAKE) top=ti_top config=$(engine)/config what="$(notdir $(config)), ti_top" $(if $(findstring jobserver,$(MAKEFLAGS)),,-j $(jobs))

config: build/setup.stamp ## Files of CONFIG= for RTL, C++ and programs, checked (SET=), in build/config
	@$(if $(folders),$(if $(filter config,$(MAKECMDGOALS)),echo $(config),true),exit 2)

sw: build/setup.stamp ## C++ programs, their tests, and the model for Python
	@$(call build_cpp,all)

registers: build/setup.stamp ## What rtl/host/ti_regs.rdl describes: register block, C header, Python model, docs/registers.md
	@python scripts/registers.py

ip: config ## CONFIG= as a block for block designs: ti_top_wrapper.v, IP-XACT, all sources (SET= OUT=)
	@python scripts/wrapper.py --out $(call out,build/ip/$(notdir $(config))) -- $(call q,CONFIG) $(overrides)

vivado: ## CONFIG= by your Vivado, from synthesis to reports (BOARD=arty_a7_100t|kv260|alveo_u55c PART= MODE=ooc|full TOP= SOURCES= SET= OUT=)
quartus: ## CONFIG= by your Quartus, from synthesis to reports (BOARD=de10_nano PART= MODE=ooc|full TOP= SOURCES= SET= OUT=)
vivado quartus: need-BOARD config
	@scripts/vendor.sh $@
	@python scripts/wrapper.py --out $(block) -- $(call q,CONFIG) $(overrides) >/dev/null
	@$(if $(filter quartus,$@),python scripts/plain_verilog.py $(block))
	@scripts/vendor.sh $@ folder=$(block) out=$(call out,build/$@/$(notdir $(config))-$(call q,BOARD)) \
	  $(call key,board,BOARD) $(call key,part,PART) $(call key,mode,MODE) $(call key,top,TOP) $(call key,sources,SOURCES)
block = build/ip/$(notdir $(config))
# key NAME,VARIABLE: name=value as one word; nothing when it is empty.
key = $(if $(value $(2)),$(1)=$(call q,$(2)))

crossings: config ## Registers of CONFIG= behind ti_top that look at another clock, each with both (SET=stream_clock=own)
	@python scripts/wrapper.py --out $(block) -- $(call q,CONFIG) $(overrides) >/dev/null
	@python scripts/crossings.py $(block)

##@ Check
test: build/setup.stamp ## Every check that CI runs (TEST=part_of_a_name for a few)
	@scripts/test.sh $(call q,TEST)

sim: check-unit model ## cocotb tests of one module (UNIT=ti_fifo TEST=part SEED= WAVES=1)
	@pytest -s tb/unit/test_$(call q,UNIT).py

waves: check-unit model ## The same with an FST, opened in a viewer (UNIT= TEST=)
	@WAVES=1 pytest tb/unit/test_$(call q,UNIT).py; status=$$?; scripts/show_waves.sh $(call q,UNIT); exit $$status

operators: config ## FP operators and memory bits of CONFIG= beside the published core (OUT=file.json)
	@python scripts/operators.py $(config) $(call opt,--json,OUT)

synth: config ## Latches, loops and memories of CONFIG= by Yosys (UNIT=ti_fp_add OUT=file.json)
	@python scripts/synth_check.py $(config) $(call opt,--unit,UNIT) $(call opt,--json,OUT)

formal: build/setup.stamp ## Proofs of the RTL's properties, covers, and a fault that each must find (UNIT="ti_fifo ti_arbiter" QUICK=1 OUT=file.json PAGE=file.md)
	@scripts/setup.sh --formal
	@python scripts/formal.py $(call words_of,--unit,UNIT) $(if $(filter-out 0,$(QUICK)),--quick) $(call opt,--json,OUT) $(call opt,--page,PAGE)

soak: sw build/scenes/knot.ply ## Random machines, scenes and rays against model and truth for hours; a failure is made small (HOURS=2 or RAYS=1000000, ROUND=17 for one again, SEED= OUT=)
	@python scripts/soak.py $(call opt,--hours,HOURS) $(call opt,--rays,RAYS) $(call opt,--round,ROUND) $(call opt,--seed,SEED) $(call opt,--out,OUT)

mutants: sw $(knot) ## Faults put into a copy of the RTL: the tests must find each (TEST=part_of_a_name QUICK=1 ALL=1), or as many of all small changes of it, as a score (GENERATED=300 SEED=1 UNIT=ti_fifo OUT=file.json)
	@$(if $(value GENERATED),python scripts/mutation_score.py --count $(call q,GENERATED) $(call opt,--seed,SEED) $(call opt,--unit,UNIT) $(call opt,--json,OUT),python scripts/mutants.py $(call opt,--only,TEST) $(if $(filter-out 0,$(QUICK)),--quick) $(if $(filter-out 0,$(ALL)),--every-check))

area: config ## Cells of CONFIG= or a unit by Yosys: LUT, FF, DSP, BRAM, gates, mm2 at 65 nm (PART="xcup xc7 ecp5 gowin osu018 sky130" UNIT= OUT=file.json BASELINE=1 REASON="...")
	@$(if $(filter osu018,$(area_parts)),[[ -f $(liberty) ]] || scripts/setup.sh --extra; scripts/setup.sh --cacti)
	@$(if $(filter sky130,$(area_parts)),scripts/setup.sh --sky130)
	@python scripts/area.py $(config) $(call words_of,--part,PART) $(call words_of,--unit,UNIT) $(call opt,--json,OUT) $(baseline)

fmax: need-PART config ## Clock of the units of CONFIG=, or of UNIT=, with the ten longest paths (PART=ecp5-85k|gowin|osu018 UNIT="ti_fp_add ti_engine" SEEDS=3 SPEED=6 LIMIT=10 OUT=file.json BASELINE=1 REASON="...")
	@$(if $(filter osu018,$(value PART)),[[ -f $(liberty) ]] && command -v sta >/dev/null || scripts/setup.sh --extra,scripts/setup.sh --synthesis)
	@python scripts/fmax.py $(config) $(call opt,--part,PART) $(call words_of,--unit,UNIT) $(call opt,--seeds,SEEDS) \
	  $(call opt,--speed,SPEED) $(call opt,--limit,LIMIT) $(call opt,--json,OUT) $(baseline)
merit: check-mem build/setup.stamp sw $(call made,$(value SCENE)) ## Mrays/s for the size: cells, clock and cycles of CONFIG="tiny small" on each PART= and SCENE=, beside published engines, in one table (PART="ecp5 xcup osu018" UNIT= SEEDS=3 N=40000 MEM= SET= FILE="those of make area, fmax and bench" OUT=)
	@$(if $(filter osu018,$(merit_parts)),[[ -f $(liberty) ]] && command -v sta >/dev/null || scripts/setup.sh --extra; scripts/setup.sh --cacti)
	@$(if $(filter sky130,$(merit_parts)),scripts/setup.sh --sky130)
	@$(if $(filter ecp5 gowin,$(merit_parts)),scripts/setup.sh --synthesis)
	@python scripts/merit.py $(call words_of,--config,CONFIG) --part $(foreach w,$(merit_parts),'$(subst ','\'',$(w))') --scene $(scene) $(call opt,--set,SET) $(call opt,--cores,CORES) \
	  $(call words_of,--unit,UNIT) $(call opt,--seeds,SEEDS) $(call words_of,--file,FILE) $(call opt,--count,N) $(memory) \
	  $(if $(filter file,$(origin SIZE)),,--frame $(call q,SIZE)) --out $(call out,build/merit)
area_parts = $(or $(value PART),osu018 sky130)
merit_parts = $(or $(value PART),ecp5 xcup osu018)
# words_of OPTION,NAME: the option with each word of the variable as a word of the shell.
words_of = $(if $(value $(2)),$(1) $(foreach w,$(value $(2)),'$(subst ','\'',$(w))'))
# BASELINE=1 compares with the file of the command and configuration in tb/baselines, REASON= writes it.
baseline = $(if $(filter-out 0,$(value BASELINE))$(value REASON),--baseline tb/baselines/$@-$(notdir $(config)).json) $(call opt,--record,REASON)

lint: build/setup.stamp ## Verilator -Wall, Verible, clang-format, Ruff
	@scripts/lint.sh

format: build/setup.stamp ## Lay out RTL, C++ and Python
	@verible-verilog-format --flagfile=lint/verible-format.flags --inplace $$(find rtl tb sim -name '*.sv' ! -name 'ti_regs*.sv')
	@clang-format -i $$(find sw sim tb -name '*.cpp' -o -name '*.hpp')
	@ruff format --quiet && ruff check --quiet --fix

certify: model ## The error bounds that the machine leans on, proved by Gappa, beside those of the code (FORMATS="8,23 7,16" TEST=part_of_a_name OUT=)
	@PYTHONPATH=build/sw python scripts/certify.py $(call opt,--formats,FORMATS) $(call opt,--only,TEST) --out $(call out,build/certify)

fp-volume: sw ## C++ FP operators against MPFR, small formats in full (PAIRS=10000000 of the others)
	@build/sw/fp_volume --pairs $(or $(call opt,,PAIRS),10000000) --seed $(or $(call opt,,SEED),1)

tree-table: build/sw/ti config ## Tree statistics of the papers' scenes beside the published ones
	@python scripts/tree_table.py build/sw/ti $(config)/config.json $(if $(value SCENES),$(call q,SCENES),../shared/scenes)

##@ House
dram: build/setup.stamp
	@scripts/setup.sh --dram

setup: ## Install what is missing (apt, Python in build/venv)
	@scripts/setup.sh

clean: ## Remove what builds and runs wrote; the set-up stays (ALL=1: that too)
	@$(if $(ALL),rm -rf build,find build -mindepth 1 -maxdepth 1 ! -name venv ! -name ccache ! -name setup.stamp ! -name dram ! -name synthesis ! -name formal ! -name cacti ! -name sky130 -exec rm -rf {} +)

help: ## Show this list
	@awk 'BEGIN {FS = ":.*## "} /^##@ / {printf "\n%s\n", substr($$0, 5)} \
	  /^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' Makefile
	@printf '\nCONFIG= is a name in configs/ or a file; SET="num_trv=2 trv_slots=16" changes keys of it.\n'

need-%:
	@[[ -n $(call q,$*) ]] || { echo "make $(firstword $(MAKECMDGOALS)): $*= is missing; 'make help' says what it is" >&2; exit 2; }

check-engine:
	@[[ " rtl top board model embree " == *" "$(call q,ENGINE)" "* ]] || \
	  { echo ENGINE=$(call q,ENGINE)": no such engine; there are rtl, top, board, model and embree" >&2; exit 2; }

no-host:
	@[[ $(call q,ENGINE) != top && $(call q,ENGINE) != board ]] || \
	  { echo ENGINE=$(call q,ENGINE)": only render and trace drive it, and gallery the top; give ENGINE=rtl" >&2; exit 2; }

check-mem:
	@[[ $(call q,MEM) =~ ^(|ideal|fixed|dram|[^,]+,[^,]+)$$ ]] || \
	  { echo MEM=$(call q,MEM)": no such memory; there are ideal, fixed and dram, and latency,bytes of a fixed one, as in 100,64" >&2; exit 2; }

check-unit: need-UNIT
	@[[ -f tb/unit/test_$(call q,UNIT).py ]] || { echo UNIT=$(call q,UNIT)": there is no tb/unit/test_"$(call q,UNIT)".py; there are" \
	  $(sort $(patsubst tb/unit/test_%.py,%,$(wildcard tb/unit/test_*.py))) >&2; exit 2; }

check-format:
	@[[ $(call q,FORMAT) =~ ^[3-8],([2-9]|1[0-9]|2[0-3])$$ ]] || \
	  { echo FORMAT=$(call q,FORMAT)": not E,M with E from 3 to 8 and M from 2 to 23, as in 8,23" >&2; exit 2; }

# --- Parts of builds ------------------------------------------------------------------------------

jobs = $(shell nproc)
# The compiler that the set-up chose; read when a recipe runs.
cxx = $(shell sed -n 1p build/setup.stamp)
# build_cpp TARGETS: of sw/, by CMake.
build_cpp = scripts/build_cpp.sh build/sw "$(1)" -DCMAKE_CXX_COMPILER=$(cxx) -DTI_PYTHON=$(CURDIR)/build/venv/bin/python

model: build/setup.stamp
	@$(call build_cpp,ti_model)
build/sw/ti: build/setup.stamp FORCE
	@$(call build_cpp,ti)
build/sw/libti_sw.a: build/setup.stamp FORCE
	@$(call build_cpp,ti_sw)
sanitized: build/setup.stamp
	@scripts/build_cpp.sh build/sanitize ti_tests -DCMAKE_CXX_COMPILER=$(cxx) -DTI_SANITIZE=ON

# Also when this folder has moved, since Python environments hold its path.
build/setup.stamp: scripts/setup.sh scripts/repair_verilator.py scripts/apt-packages.txt requirements.txt \
    $(if $(filter-out $(shell sed -n 2p build/setup.stamp 2>/dev/null),$(CURDIR)),FORCE)
	@scripts/setup.sh --if-needed

# The scenes of the project that are too large for git.
$(made_files): scripts/make_scenes.py $(wildcard scripts/scenes/*.py) | build/setup.stamp
	@python scripts/make_scenes.py --big $(@D) $(@F)

FORCE:
.PHONY: FORCE render machine trace bench compare gallery image hardcases hardcase waves-engine top-engine accuracy fidelity testfloat engine config sw test sim waves operators synth mutants area fmax merit lint \
  effects-table second-opinion convergence format certify fp-volume tree-table registers ip vivado quartus crossings setup clean help dram check-engine no-host check-mem check-unit check-format model sanitized
