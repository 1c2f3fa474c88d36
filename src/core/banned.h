/* banned.h: calls that this project does not make, turned into compile errors. The Makefile puts it in front of every C
 * source (gcc -include), so nobody can forget it. After the idea of git's banned.h.
 *
 * The headers that declare the calls come first: they must see the real names. A file may not lean on these includes;
 * one build of `make check` goes without this header to see to that. */
#ifndef VITRINE_CORE_BANNED_H
#define VITRINE_CORE_BANNED_H

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define VIT_BANNED(call) vitrine_bans_##call##_see_src_core_banned_h

/* No room for a length: vit_strprintf, snprintf, memcpy with a checked size. */
#undef strcpy
#define strcpy(to, from) VIT_BANNED(strcpy)
#undef strcat
#define strcat(to, from) VIT_BANNED(strcat)
#undef stpcpy
#define stpcpy(to, from) VIT_BANNED(stpcpy)
#undef sprintf
#define sprintf(...) VIT_BANNED(sprintf)
#undef vsprintf
#define vsprintf(to, format, arguments) VIT_BANNED(vsprintf)
#undef gets
#define gets(to) VIT_BANNED(gets)

/* May leave the text without its end, or mean the length of something else. */
#undef strncpy
#define strncpy(to, from, n) VIT_BANNED(strncpy)
#undef strncat
#define strncat(to, from, n) VIT_BANNED(strncat)

/* Hidden state shared between threads: strtok_r, strerror_r through %m, localtime_r, a generator of one's own. */
#undef strtok
#define strtok(text, delimiters) VIT_BANNED(strtok)
#undef asctime
#define asctime(t) VIT_BANNED(asctime)
#undef ctime
#define ctime(t) VIT_BANNED(ctime)
#undef gmtime
#define gmtime(t) VIT_BANNED(gmtime)
#undef localtime
#define localtime(t) VIT_BANNED(localtime)
#undef rand
#define rand() VIT_BANNED(rand)

/* Cannot say that the text was no number: strtol, strtod with an end pointer. */
#undef atoi
#define atoi(text) VIT_BANNED(atoi)
#undef atol
#define atol(text) VIT_BANNED(atol)
#undef atoll
#define atoll(text) VIT_BANNED(atoll)
#undef atof
#define atof(text) VIT_BANNED(atof)

/* File formats are read with strtod, which is right only in the C locale that every process starts with. */
#undef setlocale
#define setlocale(category, locale) VIT_BANNED(setlocale)

/* A name that somebody else can take first: mkstemp, vit_outfile. */
#undef tmpnam
#define tmpnam(to) VIT_BANNED(tmpnam)
#undef mktemp
#define mktemp(template) VIT_BANNED(mktemp)

#endif
