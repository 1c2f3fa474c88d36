/* zeta and Psi in double and single precision against the integral in long double, and the single form against the
 * double one over the whole quadrant. */
#include "vitrine/optics.h"

#include "optics_exact.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

struct worst {
    double error, a, b;
};
static void worst_take(struct worst *worst, double error, double a, double b)
{
    if (!(error <= worst->error)) /* NaN too */
        *worst = (struct worst){error, a, b};
}
static void worst_print(const char *what, struct worst worst)
{
    print_message("# %s: largest error %.3g at a = %.9g, b = %.9g\n", what, worst.error, worst.a, worst.b);
}

static void take_double(struct worst *psi, struct worst *zeta, double a, double b)
{
    struct exact_moments exact = exact_integrate((struct exact_ray){0, a, b, 1});
    worst_take(psi, fabs(vit_psi(a, b) - exact.psi), a, b);
    worst_take(zeta, fabs(vit_zeta(a, b) - exact.zeta), a, b);
}

static void test_double(void **state)
{
    (void)state;
    struct worst psi = {0}, zeta = {0};
    const double ends[] = {0, 1e-30, 1e-10, 1e-3, 0.1, 1, 4, 7.999, 8, 8.001, 16, 42, 700, 1e4, 1e10, 1e30};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(ends); i++) {
        for (size_t j = 0; j < VIT_ARRAY_LENGTH(ends); j++)
            take_double(&psi, &zeta, ends[i], ends[j]);
        take_double(&psi, &zeta, ends[i], nextafter(ends[i], INFINITY));
        take_double(&psi, &zeta, nextafter(ends[i], INFINITY), ends[i]);
    }
    for (int i = 0; i < 36; i++) {
        for (int j = 0; j < 36; j++)
            take_double(&psi, &zeta, 5 * i / (36.0 - i), 5 * j / (36.0 - j));
    }
    worst_print("psi, double", psi);
    worst_print("zeta, double", zeta);
    assert_true(psi.error <= 1e-13 && zeta.error <= 1e-13);
}

static void take_float(struct worst *psi, struct worst *zeta, struct worst *thin, float a, float b)
{
    double exact = vit_psi(a, b), got = vit_psi_float(a, b), s = 0.5 * ((double)a + b);
    worst_take(psi, fabs(got - exact), a, b);
    worst_take(zeta, fabs(vit_zeta_float(a, b) - vit_zeta(a, b)), a, b);
    if (s <= 5)
        worst_take(thin, fabs(got - exact) / fmin(1, s + 0.25), a, b);
    if (!(got <= 1 && got >= (double)vit_zeta_float(a, b)))
        worst_take(psi, INFINITY, a, b);
}

static void test_float(void **state)
{
    (void)state;
    struct worst psi = {0}, zeta = {0}, thin = {0};
    for (int i = 0; i <= 400; i++) {
        for (int j = 0; j <= 400; j++) {
            take_float(&psi, &zeta, &thin, (float)(i < 400 ? 5 * i / (400.0 - i) : INFINITY),
                       (float)(j < 400 ? 5 * j / (400.0 - j) : INFINITY));
            take_float(&psi, &zeta, &thin, (float)pow(10, (i - 200) / 10.0), (float)pow(10, (j - 200) / 10.0));
            take_float(&psi, &zeta, &thin, (float)(12.6 * i / 400),
                       (float)(12.6 * j / 400)); /* across the seams at s = 5 and 12 */
        }
        float x = (float)pow(10, (i - 200) / 6.0);
        take_float(&psi, &zeta, &thin, x, nextafterf(x, INFINITY));
        take_float(&psi, &zeta, &thin, nextafterf(x, INFINITY), x);
        take_float(&psi, &zeta, &thin, x, 0);
        take_float(&psi, &zeta, &thin, 0, x);
    }
    worst_print("psi, float", psi);
    worst_print("zeta, float", zeta);
    worst_print("psi, float, thin slabs", thin);
    assert_true(psi.error <= 1e-6 && zeta.error <= 1e-6 && thin.error <= 1e-6);
}

static void test_ends(void **state)
{
    (void)state;
    assert_true(vit_psi(0, 0) == 1 && vit_zeta(0, 0) == 1 && vit_psi_float(0, 0) == 1 && vit_zeta_float(0, 0) == 1);
    const double odd[] = {INFINITY, 1e300, 1e30, -1, -INFINITY, NAN, 5e-324, 0};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(odd); i++) {
        for (size_t j = 0; j < VIT_ARRAY_LENGTH(odd); j++) {
            double psi = vit_psi(odd[i], odd[j]);
            float single = vit_psi_float((float)odd[i], (float)odd[j]),
                  zeta = vit_zeta_float((float)odd[i], (float)odd[j]);
            assert_true(psi >= 0 && psi <= 1 && single >= 0 && single <= 1 && zeta >= 0 && zeta <= 1);
            assert_true(fabs(psi - single) <= 1e-6);
        }
    }
    assert_true(vit_psi(INFINITY, 0) <= 1e-13 && vit_psi(0, INFINITY) <= 1e-13);
    assert_true(vit_psi_float(INFINITY, 0) <= 1e-6f && vit_psi_float(0, INFINITY) <= 1e-6f);
}

/* Arrays give what single calls give, whatever the length and however thick and thin mix: within the bound of each, as
 * the deepest segment of a block decides which of two forms serves it. */
static void test_array(void **state)
{
    (void)state;
    enum { MOST = 300 };
    float a[MOST], b[MOST], zeta[MOST + 1], psi[MOST + 1];
    for (int i = 0; i < MOST; i++) {
        a[i] = (float)(i % 7 == 0 ? 30.0 * i : 0.01 * i);
        b[i] = (float)(i % 11 == 0 ? 0.0 : 3.0 - 0.01 * i);
    }
    double worst = 0;
    for (size_t n = 0; n <= MOST; n += 1 + n / 3) {
        zeta[n] = psi[n] = -1;
        vit_zeta_psi_array(n, a, b, zeta, psi);
        assert_true(zeta[n] == -1 && psi[n] == -1);
        for (size_t i = 0; i < n; i++) {
            worst = fmax(worst, fabs((double)zeta[i] - vit_zeta_float(a[i], b[i])));
            worst = fmax(worst, fabs((double)psi[i] - vit_psi_float(a[i], b[i])));
        }
    }
    print_message("# arrays and single calls differ by at most %.3g\n", worst);
    assert_true(worst <= 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_double),
        cmocka_unit_test(test_float),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_array),
    };
    return cmocka_run_group_tests_name("optics_psi", tests, NULL, NULL);
}
