# Vitrine: one non-recursive Makefile. `make help` lists what it can do.
#
# CONFIG = release | debug | asan | fuzz | cov       build/$(CONFIG)/vitrine is the binary
# CC, CXX, CPPFLAGS, CFLAGS, CXXFLAGS, LDFLAGS belong to the packager; ours are the VIT_ ones below.
# WERROR=0|1: warnings are errors. V=1 shows the commands. CLANG=clang, CLANGXX=clang++ name the second compiler.

CONFIG ?= release
BUILD ?= build
O := $(BUILD)/$(CONFIG)
PREFIX ?= /usr/local
DESTDIR ?=
CLANG ?= clang
CLANGXX ?= clang++
V ?= 0

ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
ifeq ($(CONFIG),fuzz)
CC := $(CLANG)
CXX := $(CLANGXX)
endif
# All cores; -j on the command line wins, and a make inside make shares its parent's.
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc 2>/dev/null || echo 1)
endif
MAKEFLAGS += --no-print-directory
.DEFAULT_GOAL := all
.SUFFIXES:
.DELETE_ON_ERROR:
.SECONDARY:
Q := $(if $(filter 1,$(V)),,@)
say = $(if $(filter 1,$(V)),,@printf '%-5s %s\n' '$(1)' '$(2)')

# Packages -------------------------------------------------------------------------------------------------
# Both fragments are made by installing what is missing; make then starts over with them. Goals that build nothing
# need neither; goals that only build the binary do not need what the tests need.
PKGS := libopenjp2 libzip expat egl glesv2 libpng zlib yaml-0.1 jansson cairo gbm libdrm libseat libinput xkbcommon
HOST_GOALS := help clean install-deps install-deps-check uninstall include-rules
BUILD_GOALS := all run install $(O)/vitrine
GOALS := $(or $(MAKECMDGOALS),all)
ifneq ($(filter-out $(HOST_GOALS),$(GOALS)),)
include $(BUILD)/packages.mk
endif
ifneq ($(filter-out $(HOST_GOALS) $(BUILD_GOALS),$(GOALS)),)
include $(BUILD)/packages-check.mk
endif
# `pkg-config --cflags dcmtk` asks for libsndfile's headers, which we do not need; its libraries do not.
$(BUILD)/packages.mk: Makefile packaging/install-deps.sh
	@packaging/install-deps.sh build
	@mkdir -p $(@D)
	@{ set -e; cflags=$$(pkg-config --cflags $(PKGS)) libs=$$(pkg-config --libs $(PKGS)) dcmtk=$$(pkg-config --libs dcmtk); \
	   echo "PKG_CFLAGS := $$cflags"; echo "PKG_LIBS := $$libs"; echo "DCMTK_LIBS := $$dcmtk"; } >$@.tmp
	@mv $@.tmp $@
$(BUILD)/packages-check.mk: Makefile packaging/install-deps.sh | $(BUILD)/packages.mk
	@packaging/install-deps.sh check
	@{ set -e; libs=$$(pkg-config --libs cmocka); echo "CMOCKA_LIBS := $$libs"; } >$@.tmp
	@mv $@.tmp $@

# Flags -----------------------------------------------------------------------------------------------------
# With the compilers that we test with, warnings are errors by default; others may know warnings that we do not.
COMPILER_VERSION := $(notdir $(CC))-$(shell $(CC) -dumpversion 2>/dev/null)
WERROR ?= $(if $(filter gcc-12 clang-14.%,$(COMPILER_VERSION)),1,0)
# A table ends in {NULL}: what is left out of it is zero, and meant.
VIT_WARN := -Wall -Wextra -Wno-missing-field-initializers -Wshadow -Wpointer-arith -Wundef -Wvla -Wformat=2
# A loop that the sanitizers keep clang from vectorising is no fault of the source.
VIT_WARN += $(if $(findstring clang,$(CC)),-Wno-pass-failed)
VIT_CWARN := -Wstrict-prototypes -Wmissing-prototypes -Wold-style-definition
ifeq ($(WERROR),1)
VIT_WARN += -Werror
endif
OPT_release := -O2 -g -DNDEBUG
OPT_debug := -O0 -g3
OPT_asan := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
OPT_fuzz := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=undefined -DVIT_FUZZ
OPT_cov := -O0 -g --coverage
ifeq ($(origin OPT_$(CONFIG)),undefined)
$(error CONFIG=$(CONFIG) is not one of: release debug asan fuzz cov)
endif
# -ffp-contract=off: the same arithmetic on every CPU. The two -fno- let loops with sqrt and ?: vectorise; results stay. -ffile-prefix-map: the same binary from every folder (gcov needs
# the real names).
VIT_CODEGEN := $(OPT_$(CONFIG)) -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp $(if $(filter cov,$(CONFIG)),,-ffile-prefix-map=$(CURDIR)=.)
VIT_CPPFLAGS = -D_GNU_SOURCE -Iinclude -Isrc -I$(O)/gen $(PKG_CFLAGS)
VIT_CFLAGS = -std=c11 $(VIT_WARN) $(VIT_CWARN) $(VIT_CODEGEN)
VIT_CXXFLAGS = -std=c++17 $(VIT_WARN) $(VIT_CODEGEN)
VIT_LDFLAGS = $(filter -fsanitize% --coverage -g,$(OPT_$(CONFIG))) -fopenmp -Wl,--as-needed
VIT_LDLIBS = $(PKG_LIBS) $(DCMTK_LIBS) -lpthread -lm
BANNED := src/core/banned.h

# Everything that changes an object without changing a source: a change here rebuilds.
FLAGS_NOW = $(COMPILER_VERSION) $(CXX) $(VIT_CPPFLAGS) $(VIT_CFLAGS) $(VIT_CXXFLAGS) $(VIT_LDFLAGS) $(VIT_LDLIBS) \
    $(BANNED) | $(CPPFLAGS) | $(CFLAGS) | $(CXXFLAGS) | $(LDFLAGS)
$(O)/flags: FORCE
	@mkdir -p $(@D)
	@printf '%s\n' '$(FLAGS_NOW)' | cmp -s - $@ || printf '%s\n' '$(FLAGS_NOW)' >$@

# Sources ---------------------------------------------------------------------------------------------------
HEADERS := $(sort $(wildcard include/vitrine/*.h src/*/*.h))
C_SRC := $(sort $(wildcard src/*/*.c))
CC_SRC := $(sort $(wildcard src/*/*.cc))
TEST_SRC := $(sort $(wildcard tests/unit/*.c tests/gl/*.c tests/fuzz/*.c tests/bench/*.c tests/bench/preload/*.c tests/kms/*.c tests/kms/preload/*.c))
TEST_HEADERS := $(sort $(wildcard tests/*/*.h))
PRESETS := $(sort $(wildcard configs/presets/*.yaml))
SHADERS := $(sort $(wildcard shaders/*.vert shaders/*.frag shaders/*.glsl))
MAIN_SRC := src/app/main.c
GEN_SRC := $(O)/gen/presets_builtin.c $(O)/gen/shader_sources.c
LIB_OBJ := $(patsubst %.c,$(O)/%.o,$(filter-out $(MAIN_SRC),$(C_SRC))) $(CC_SRC:%.cc=$(O)/%.o) $(GEN_SRC:.c=.o)
LIB := $(O)/libvitrine.a
BIN := $(O)/vitrine
test_bins = $(patsubst %.c,$(O)/%,$(sort $(wildcard tests/$(1)/*_$(2).c)))
UNIT_BIN := $(call test_bins,unit,test)
GL_BIN := $(call test_bins,gl,test)
FUZZ_BIN := $(call test_bins,fuzz,fuzz)
GOLDEN := $(sort $(wildcard tests/golden/*.sh))
KMS_BIN := $(patsubst %.c,$(O)/%,$(sort $(wildcard tests/kms/*.c)))
KMS_LIB := $(patsubst %.c,$(O)/%.so,$(sort $(wildcard tests/kms/preload/*.c)))
BENCH_BIN := $(patsubst %.c,$(O)/%,$(sort $(wildcard tests/bench/*.c)))
BENCH := $(sort $(wildcard tests/bench/*.sh))
ALL_OBJ := $(LIB_OBJ) $(MAIN_SRC:%.c=$(O)/%.o) $(patsubst %,%.o,$(UNIT_BIN) $(GL_BIN) $(FUZZ_BIN) $(BENCH_BIN) $(KMS_BIN)) $(O)/tests/fuzz/replay.o

##
## Build
##
.PHONY: all
all: $(BIN) ## the binary, build/$(CONFIG)/vitrine (default)

# A list of files is an input too: adding or removing one changes it.
$(O)/gen/%.list: FORCE
	@mkdir -p $(@D)
	@echo '$(GEN_LIST)' | cmp -s - $@ || echo '$(GEN_LIST)' >$@
$(O)/gen/presets_builtin.list: GEN_LIST = $(PRESETS)
$(O)/gen/shader_sources.list: GEN_LIST = $(SHADERS)
$(O)/gen/presets_builtin.c: packaging/embed.sh $(O)/gen/presets_builtin.list $(PRESETS)
	$(call say,EMBED,$@)
	$(Q)packaging/embed.sh vit_preset_builtin vit_presets_builtin vitrine/config.h yaml $(PRESETS) >$@.tmp && mv $@.tmp $@
$(O)/gen/shader_sources.c: packaging/embed.sh $(O)/gen/shader_sources.list $(SHADERS)
	$(call say,EMBED,$@)
	$(Q)packaging/embed.sh vit_shader_source vit_shader_sources vitrine/gl.h keep $(SHADERS) >$@.tmp && mv $@.tmp $@

$(O)/%.o: %.c $(O)/flags
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CFLAGS) $(addprefix -include ,$(BANNED)) $(CFLAGS) -MMD -MP -c $< -o $@
$(O)/%.o: %.cc $(O)/flags
	@mkdir -p $(@D)
	$(call say,CXX,$@)
	$(Q)$(CXX) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CXXFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@
$(O)/gen/%.o: $(O)/gen/%.c $(O)/flags
	$(call say,CC,$@)
	$(Q)$(CC) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CFLAGS) $(CFLAGS) -MMD -MP -c $< -o $@
$(LIB): $(LIB_OBJ)
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) rcsD $@ $^
$(BIN): $(MAIN_SRC:%.c=$(O)/%.o) $(LIB)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(VIT_LDFLAGS) $(LDFLAGS) $^ $(VIT_LDLIBS) -o $@
# One test binary per file, linked with the whole library. frames_test counts what this project's own code acquires.
WRAPPED := malloc calloc realloc aligned_alloc fopen open glCreateShader glCreateProgram glCompileShader glLinkProgram \
    glProgramBinary glGenTextures glGenFramebuffers glTexStorage2D glTexStorage3D glTexImage2D glTexImage3D
$(O)/tests/gl/frames_test: private TEST_LDFLAGS := $(WRAPPED:%=-Wl,--wrap=%)
# Without libFuzzer a fuzz target reads the files that it is given.
$(FUZZ_BIN): $(O)/%: $(O)/%.o $(if $(filter fuzz,$(CONFIG)),,$(O)/tests/fuzz/replay.o) $(LIB)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(VIT_LDFLAGS) $(if $(filter fuzz,$(CONFIG)),-fsanitize=fuzzer) $(LDFLAGS) $^ $(VIT_LDLIBS) -o $@
$(O)/tests/%: $(O)/tests/%.o $(LIB)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(VIT_LDFLAGS) $(TEST_LDFLAGS) $(LDFLAGS) $^ $(VIT_LDLIBS) $(CMOCKA_LIBS) -o $@

# To be preloaded: without the library, and without the sanitizers.
$(O)/tests/kms/preload/%.so: tests/kms/preload/%.c $(O)/flags
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(VIT_CPPFLAGS) $(CPPFLAGS) -std=c11 -O2 -fPIC -shared $(CFLAGS) $< -ldl -o $@

-include $(ALL_OBJ:.o=.d)

.PHONY: run
run: $(BIN) ## install what is missing, build, show the built-in head full screen, or draw it into build/vitrine.png
	@packaging/run.sh $(BIN) $(BUILD)/vitrine.png

SHARE = $(DESTDIR)$(PREFIX)/share
MAN := $(O)/gen/vitrine.1
$(MAN): packaging/man.sh $(BIN)
	$(call say,MAN,$@)
	$(Q)packaging/man.sh $(BIN) >$@.tmp && mv $@.tmp $@
.PHONY: install uninstall
install: $(BIN) $(MAN) ## binary, presets, example of a kiosk file, licence and man page under $(DESTDIR)$(PREFIX)
	install -D -m 755 $(BIN) $(DESTDIR)$(PREFIX)/bin/vitrine
	install -D -m 644 -t $(SHARE)/doc/vitrine LICENSE $(wildcard README.md)
	$(if $(PRESETS),install -D -m 644 -t $(SHARE)/vitrine/presets $(PRESETS))
	install -D -m 644 -t $(SHARE)/vitrine configs/kiosk.yaml
	install -D -m 644 -t $(SHARE)/man/man1 $(MAN)
uninstall: ## takes away what install put there
	rm -f $(DESTDIR)$(PREFIX)/bin/vitrine $(SHARE)/man/man1/vitrine.1
	rm -rf $(SHARE)/vitrine $(SHARE)/doc/vitrine

##
## Test (all of these install what is missing and build first)
##
RUN := tests/run.sh VITRINE=$(BIN)
KMS_RUN := TEST_TIMEOUT=270 KMS_LIMIT=240 KMS_CACHE=$(BUILD)/kms tests/kms/show.sh TEST_TIMEOUT=300
.PHONY: unit gl golden kms lint headers include-rules
unit: $(UNIT_BIN) ## unit tests; seconds
	@$(RUN) $(UNIT_BIN)
gl: $(GL_BIN) ## tests that need a GL context (surfaceless; llvmpipe will do)
	@$(RUN) $(GL_BIN)
golden: $(BIN) ## shell tests of the whole binary
	@$(RUN) $(GOLDEN)
kms: $(BIN) $(KMS_BIN) $(KMS_LIB) ## `show` on emulated cards, under QEMU (skipped without it; KMS_FULL=1: all, KMS_SCENES="keys:virtio:320x240 ...": these)
	@$(RUN) KMS_CACHE=$(BUILD)/kms TEST_TIMEOUT=10000 KMS_LIMIT=900 tests/kms/show.sh
headers: $(GEN_SRC) ## every header compiles alone: C11, and C++17 where it is meant for C++
	@$(RUN) $(HEADER_RUN)
include-rules: ## who may include whom (ARCHITECTURE: modules), and what may stand where
	@tests/run.sh $(RULES_RUN)
lint: lint-stamps ## clang-format, clang-tidy, cppcheck, shellcheck
	@$(RUN) $(call lint_run,tidy)

RULES_RUN := tests/tools/include-rules.sh tests/tools/include-rules-test.sh
HEADER_RUN = HEADER_CC=$(CC) HEADER_CXX=$(CXX) 'HEADER_CPPFLAGS=$(VIT_CPPFLAGS)' tests/tools/headers.sh
lint_run = TEST_TIMEOUT=300 LINT_DIR=$(BUILD)/lint 'LINT_FILES=$(LINT_SRC) $(LINT_HEADERS)' LINT_TIDY=$1 \
    'LINT_SCRIPTS=$(SCRIPTS)' tests/tools/lint.sh

# One stamp per source and tool, so that they run in parallel and only for what changed. A stamp with text in it is a
# finding: it is shown by tests/tools/lint.sh, and taken away so that the next run looks again.
LINT_SRC := $(C_SRC) $(CC_SRC) $(TEST_SRC)
LINT_HEADERS := $(HEADERS) $(TEST_HEADERS)
SCRIPTS := .ci/run $(sort $(wildcard packaging/*.sh tests/*.sh tests/*/*.sh tests/*/*/*.sh))
# clang's analyzer, and DCMTK's headers, take nineteen twentieths of clang-tidy's time: `check` leaves both to `lint`
# and `check-full`.
TIDY_STAMPS := $(patsubst %,$(BUILD)/lint/%.tidy,$(LINT_SRC))
QUICK_STAMPS := $(patsubst %.c.tidy,%.c.quick,$(filter %.c.tidy,$(TIDY_STAMPS)))
.PHONY: lint-stamps lint-stamps-quick
lint-stamps: $(TIDY_STAMPS) $(BUILD)/lint/cppcheck
lint-stamps-quick: $(QUICK_STAMPS) $(BUILD)/lint/cppcheck
TIDY_INPUT := .clang-tidy tests/.clang-tidy $(HEADERS) $(TEST_HEADERS)
define tidy
@mkdir -p $(@D)
$(call say,TIDY,$<)
$(Q)clang-tidy --quiet $1 $< -- $(if $(filter %.cc,$<),-std=c++17,-std=c11) $(VIT_CPPFLAGS) $(VIT_WARN) -fopenmp \
    >$@ 2>$@.err || cat $@.err >>$@
@rm -f $@.err
endef
$(TIDY_STAMPS): $(BUILD)/lint/%.tidy: % $(TIDY_INPUT) | $(GEN_SRC)
	$(call tidy)
$(QUICK_STAMPS): $(BUILD)/lint/%.quick: % $(TIDY_INPUT) | $(GEN_SRC)
	$(call tidy,--checks=-clang-analyzer-*)
$(BUILD)/lint/cppcheck: $(LINT_SRC) $(LINT_HEADERS) tests/tools/cppcheck.supp
	@mkdir -p $(@D) $(BUILD)/lint/cppcheck.cache
	$(call say,CHECK,cppcheck)
	$(Q)cppcheck --quiet --std=c11 --std=c++17 --enable=warning,performance,portability --inline-suppr \
	    --suppressions-list=tests/tools/cppcheck.supp --cppcheck-build-dir=$(BUILD)/lint/cppcheck.cache -Iinclude -Isrc \
	    -D__GNUC__ -D_GNU_SOURCE --template=gcc src tests >$@ 2>&1 || echo "cppcheck failed" >>$@

.PHONY: asan clang fuzz fuzz-bins tests-bins
tests-bins: $(BIN) $(UNIT_BIN) $(GL_BIN) $(KMS_BIN)
ASAN_O := $(BUILD)/asan
# Under a sanitizer these take minutes: `check` leaves them to `check-full`.
ASAN_LONG := $(addprefix $(O)/tests/gl/,beside_test change_test es2_test frames_test ideal_test light_test pipeline_test rules_test \
    shaders_test stacks_test) \
    $(addprefix tests/golden/,report.sh report_stiff.sh snapshot.sh stacks.sh)
asan_run = TEST_LABEL=asan TEST_NOTES=0 TEST_TIMEOUT=900 VITRINE=$(ASAN_O)/vitrine \
    $(patsubst $(O)/%,$(ASAN_O)/%,$1) TEST_LABEL= TEST_NOTES=1 TEST_TIMEOUT=300 VITRINE=$(BIN)
ASAN_RUN = $(call asan_run,$(filter-out $(ASAN_LONG),$(UNIT_BIN) $(GL_BIN) $(GOLDEN)))
ASAN_LONG_RUN = $(call asan_run,$(filter $(ASAN_LONG),$(GL_BIN) $(GOLDEN)))
asan: asan-bins ## the whole suite under AddressSanitizer and UBSan
	@tests/run.sh $(ASAN_RUN) $(ASAN_LONG_RUN)
clang: clang-bins ## everything built by the second compiler, and the unit tests run
	@tests/run.sh $(CLANG_RUN)
CLANG_O := $(BUILD)/clang/debug
CLANG_RUN = TEST_LABEL=clang TEST_NOTES=0 $(patsubst $(O)/%,$(CLANG_O)/%,$(UNIT_BIN)) TEST_LABEL= TEST_NOTES=1
.PHONY: asan-bins clang-bins fuzz-build
asan-bins:
	+@$(MAKE) CONFIG=asan WERROR=1 tests-bins fuzz-bins
# Without banned.h, which includes <stdio.h> and others for everybody: here every file must do so itself.
clang-bins:
	+@$(MAKE) BUILD=$(BUILD)/clang CONFIG=debug CC=$(CLANG) CXX=$(CLANGXX) BANNED= WERROR=1 tests-bins
fuzz-bins: $(FUZZ_BIN)
fuzz-build:
	+@$(MAKE) CONFIG=fuzz WERROR=1 fuzz-bins
FUZZ_SECONDS ?= 10
FUZZ_RUN = TEST_TIMEOUT=600 FUZZ_SECONDS=$(FUZZ_SECONDS) FUZZ_DIR=$(BUILD)/fuzz/tests/fuzz tests/tools/fuzz.sh
SEEDS_RUN := FUZZ_SECONDS=0 FUZZ_DIR=$(ASAN_O)/tests/fuzz tests/tools/fuzz.sh
fuzz: fuzz-build ## build the fuzz targets with clang and run each for FUZZ_SECONDS (10)
	@tests/run.sh $(FUZZ_RUN)

.PHONY: check check-full check-bins
# WERROR=1 here and not by default's leave, so that CI is strict with every compiler. What ASAN_ONLY does in a sanitizer
# build it need not do twice; `check` lets every third acquisition fail.
ASAN_ONLY := $(O)/tests/gl/faults_test
CHECK_RUN = tests/tools/run-test.sh $(HEADER_RUN) $(RULES_RUN) $(call lint_run,quick) TEST_TIMEOUT=300 $(UNIT_BIN) \
    $(filter-out $(ASAN_ONLY),$(GL_BIN)) $(GOLDEN) $(KMS_RUN) FAULT_STEP=3 $(ASAN_RUN) FAULT_STEP=1 $(SEEDS_RUN)
check: ## what CI runs: lint, rules, gcc, unit, gl, golden, a screen, sanitizers, what fuzzing found
	+@$(MAKE) WERROR=1 check-bins
	@$(RUN) $(CHECK_RUN)
check-bins: tests-bins $(KMS_LIB) asan-bins lint-stamps-quick $(BENCH_BIN)
check-full: check lint clang-bins fuzz-build ## check, then the long ones: clang, screens, sanitizers, fuzzing for a while, tests/golden/full
	@$(RUN) $(CLANG_RUN) $(ASAN_LONG_RUN) $(ASAN_ONLY) $(call asan_run,$(ASAN_ONLY))
	@$(RUN) KMS_CACHE=$(BUILD)/kms KMS_FULL=1 KMS_LIMIT=3600 TEST_TIMEOUT=20000 tests/kms/show.sh
	@$(RUN) TEST_TIMEOUT=3600 $(sort $(wildcard tests/golden/full/*.sh)) $(FUZZ_RUN)

.PHONY: cov bench bench-peers
cov: ## lines that the unit, gl and golden tests reach, by file
	+@$(MAKE) CONFIG=cov tests-bins
	@find $(BUILD)/cov -name '*.gcda' -delete
	@tests/run.sh VITRINE=$(BUILD)/cov/vitrine $(patsubst $(O)/%,$(BUILD)/cov/%,$(UNIT_BIN) $(GL_BIN)) $(GOLDEN)
	@tests/tools/coverage.sh $(BUILD)/cov
bench-peers: $(BIN) ## beside VTK and VolPack: time and error, build/release/tests/bench/peers/peers.{csv,md,svg}
	@VITRINE=$(BIN) tests/bench/peers/run.sh $(O)/tests/bench/peers $(PEERS)
bench: $(BIN) $(BENCH_BIN) ## figures for speed and memory; never part of a test
	@for bench in $(BENCH); do echo "# $$bench"; VITRINE=$(BIN) BENCH_DIR=$(O)/tests/bench $$bench || exit 1; done

##
## Other
##
.PHONY: format install-deps install-deps-check clean help FORCE
format: ## clang-format everything in place
	clang-format -i $(LINT_SRC) $(LINT_HEADERS)
install-deps: ## only install the packages that building needs
	packaging/install-deps.sh build
install-deps-check: ## only install the packages that testing needs
	packaging/install-deps.sh check
clean: ## remove build/
	rm -rf $(BUILD)
help: ## this list
	@sed -n 's/^\([a-z-]*\):.* ## /\1\t/p; s/^## *//p' $(firstword $(MAKEFILE_LIST)) | awk -F '\t' \
	    'NF > 1 { printf "  make %-20s %s\n", $$1, $$2; next } { print }'
FORCE:
