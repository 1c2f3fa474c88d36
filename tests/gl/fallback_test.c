/* Never a black screen: where auto chose the 3d path and an upload fails, the picture is drawn with stacks. */
#include "app/app_private.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void a_failed_upload_leads_to_stacks(void **state)
{
    (void)state;
    enum { MOST = 60 };
    int by_stacks = 0, by_3d = 0, failed = 0;
    for (uint64_t nth = 1; nth <= MOST; nth += 3) {
        struct vit_settings settings;
        struct app app;
        struct app_scene scene;
        struct app_drawer drawer;
        char *argv[] = {"vitrine", "snapshot", "phantom:block", "--size", "16x16", "-o", "out.png"};
        app_init(&app, &settings);
        app.log.write = NULL;
        app.log.level = VIT_LOG_UNKNOWN;
        assert_true(vit_settings_parse(&settings, VIT_ARRAY_LENGTH(argv), argv, &app.log));
        assert_int_equal(app_scene_open(&scene, &app), VIT_EXIT_DONE);
        assert_true(app_drawer_open(&drawer, &scene));
        assert_int_equal(scene.plan.path, VIT_PATH_3D);
        vit_fault_arm(nth);
        bool drawn = app_drawer_draw(&drawer, &scene, &app);
        vit_fault_arm(0);
        by_stacks += drawn && scene.plan.path == VIT_PATH_STACKS;
        by_3d += drawn && scene.plan.path == VIT_PATH_3D;
        failed += !drawn;
        app_drawer_close(&drawer);
        app_scene_close(&scene);
        app_finish(&app);
    }
    print_message("# of %d faults: %d drawn with stacks, %d with 3d all the same, %d not\n", MOST / 3, by_stacks, by_3d,
                  failed);
    assert_true(by_stacks > 0 && failed < by_stacks + by_3d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_failed_upload_leads_to_stacks)};
    return cmocka_run_group_tests_name("fallback", tests, NULL, NULL);
}
