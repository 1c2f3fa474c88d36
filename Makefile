# Vitrine: one non-recursive Makefile. `make help` lists what it can do.
#
#   make run      installs what is missing, builds, shows the picture (or writes build/vitrine.png and says so)
#   make check    installs what is missing, builds, runs lint and every quick test
#
# CONFIG = release | debug | asan | fuzz | cov       build/$(CONFIG)/vitrine is the binary
# CC, CXX, CPPFLAGS, CFLAGS, CXXFLAGS, LDFLAGS belong to the packager; ours are the VIT_ ones below.

CONFIG ?= release
BUILD ?= build
O := $(BUILD)/$(CONFIG)
PREFIX ?= /usr/local
DESTDIR ?=
# WERROR=1 (CI) makes every warning an error.
WERROR ?= 0

ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
ifeq ($(filter -j%,$(MAKEFLAGS)),)
MAKEFLAGS += -j$(shell nproc 2>/dev/null || echo 1)
endif
.DEFAULT_GOAL := all
.SUFFIXES:
.DELETE_ON_ERROR:
.SECONDARY:

# Packages -------------------------------------------------------------------------------------------------
# The fragment is made after missing packages were installed; make then starts over with it. Goals that build
# nothing do not need it.
PKGS := egl glesv2 gbm libdrm libpng zlib yaml-0.1 cglm jansson
NO_SETUP_GOALS := help clean install-deps format
ifneq ($(filter-out $(NO_SETUP_GOALS),$(or $(MAKECMDGOALS),all)),)
include $(BUILD)/packages.mk
endif
$(BUILD)/packages.mk: Makefile packaging/install-deps.sh
	@packaging/install-deps.sh
	@mkdir -p $(@D)
	@{ echo "PKG_CFLAGS := $$(pkg-config --cflags $(PKGS))"; \
	   echo "PKG_LIBS := $$(pkg-config --libs $(PKGS))"; \
	   echo "DCMTK_LIBS := $$(pkg-config --libs dcmtk)"; \
	   echo "CMOCKA_LIBS := $$(pkg-config --libs cmocka)"; } >$@.tmp && mv $@.tmp $@

# Flags -----------------------------------------------------------------------------------------------------
VIT_WARN := -Wall -Wextra -Wshadow -Wpointer-arith -Wundef -Wvla -Wformat=2
VIT_CWARN := -Wstrict-prototypes -Wmissing-prototypes -Wold-style-definition
ifeq ($(WERROR),1)
VIT_WARN += -Werror
endif
OPT_release := -O2 -g -ffp-contract=off -DNDEBUG
OPT_debug := -O0 -g3 -ffp-contract=off -DVIT_FAULTS
OPT_asan := -O1 -g -ffp-contract=off -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined -DVIT_FAULTS
OPT_fuzz := -O1 -g -ffp-contract=off -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -DVIT_FUZZ -DVIT_FAULTS
OPT_cov := -O0 -g --coverage -DVIT_FAULTS
ifeq ($(origin OPT_$(CONFIG)),undefined)
$(error CONFIG=$(CONFIG) is not one of: release debug asan fuzz cov)
endif
ifeq ($(CONFIG),fuzz)
CC := clang
CXX := clang++
endif
VIT_CPPFLAGS = -D_GNU_SOURCE -Iinclude -Isrc -I$(O)/gen $(PKG_CFLAGS)
VIT_CFLAGS = -std=c11 $(VIT_WARN) $(VIT_CWARN) $(OPT_$(CONFIG)) -fopenmp -MMD -MP
VIT_CXXFLAGS = -std=c++17 $(VIT_WARN) $(OPT_$(CONFIG)) -fopenmp -MMD -MP
VIT_LDFLAGS = $(filter -fsanitize% --coverage -g,$(OPT_$(CONFIG))) -fopenmp -Wl,--as-needed
VIT_LDLIBS = $(PKG_LIBS) $(DCMTK_LIBS) -lpthread -lm

# Everything that changes an object without changing a source: a change here rebuilds.
FLAGS_NOW = $(CC) $(CXX) $(VIT_CPPFLAGS) $(VIT_CFLAGS) $(VIT_CXXFLAGS) $(VIT_LDFLAGS) $(VIT_LDLIBS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS)
$(O)/flags: FORCE
	@mkdir -p $(@D)
	@printf '%s\n' '$(FLAGS_NOW)' | cmp -s - $@ || printf '%s\n' '$(FLAGS_NOW)' >$@

# Sources ---------------------------------------------------------------------------------------------------
C_SRC := $(sort $(wildcard src/*/*.c))
CC_SRC := $(sort $(wildcard src/dicom/*.cc))
MAIN_SRC := src/app/main.c
GEN_SRC := $(O)/gen/presets_builtin.c $(O)/gen/shader_sources.c
LIB_OBJ := $(patsubst %.c,$(O)/%.o,$(filter-out $(MAIN_SRC),$(C_SRC))) $(patsubst %.cc,$(O)/%.o,$(CC_SRC)) $(GEN_SRC:.c=.o)
LIB := $(O)/libvitrine.a
BIN := $(O)/vitrine
UNIT_SRC := $(sort $(wildcard tests/unit/*_test.c))
UNIT_BIN := $(patsubst tests/%.c,$(O)/tests/%,$(UNIT_SRC))
GL_SRC := $(sort $(wildcard tests/gl/*_test.c))
GL_BIN := $(patsubst tests/%.c,$(O)/tests/%,$(GL_SRC))

.PHONY: all
all: $(BIN)

$(O)/gen/presets_builtin.c: packaging/embed.sh $(sort $(wildcard configs/presets/*.yaml)) | $(O)/flags
	@mkdir -p $(@D)
	packaging/embed.sh vit_preset_builtin vit_presets_builtin vitrine/config.h yaml $(wordlist 2,999,$^) >$@.tmp && mv $@.tmp $@
$(O)/gen/shader_sources.c: packaging/embed.sh $(sort $(wildcard shaders/*.vert shaders/*.frag shaders/*.glsl)) | $(O)/flags
	@mkdir -p $(@D)
	packaging/embed.sh vit_shader_source vit_shader_sources vitrine/gl.h keep $(wordlist 2,999,$^) >$@.tmp && mv $@.tmp $@

$(O)/%.o: %.c $(O)/flags
	@mkdir -p $(@D)
	$(CC) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CFLAGS) $(CFLAGS) -c $< -o $@
$(O)/%.o: %.cc $(O)/flags
	@mkdir -p $(@D)
	$(CXX) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CXXFLAGS) $(CXXFLAGS) -c $< -o $@
$(O)/gen/%.o: $(O)/gen/%.c $(O)/flags
	$(CC) $(VIT_CPPFLAGS) $(CPPFLAGS) $(VIT_CFLAGS) $(CFLAGS) -c $< -o $@
$(LIB): $(LIB_OBJ)
	@rm -f $@
	$(AR) rcs $@ $^
$(BIN): $(O)/src/app/main.o $(LIB)
	$(CXX) $(VIT_LDFLAGS) $(LDFLAGS) $^ $(VIT_LDLIBS) -o $@
# One test binary per file, cmocka, linked with the whole library.
$(O)/tests/%: $(O)/tests/%.o $(LIB)
	$(CXX) $(VIT_LDFLAGS) $(LDFLAGS) $^ $(VIT_LDLIBS) $(CMOCKA_LIBS) -o $@

-include $(patsubst %.o,%.d,$(LIB_OBJ)) $(O)/src/app/main.d $(patsubst %,%.d,$(UNIT_BIN) $(GL_BIN))

# Tests -----------------------------------------------------------------------------------------------------
.PHONY: unit
unit: $(UNIT_BIN)
	@tests/run.sh $(UNIT_BIN)

.PHONY: clean FORCE
clean:
	rm -rf $(BUILD)
FORCE:
