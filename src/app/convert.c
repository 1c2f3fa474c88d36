/* vitrine convert: any readable input as a CT series (a folder) or as NRRD. */
#include "app_private.h"

enum vit_exit app_convert(struct app *app)
{
    enum vit_exit status = app_output_check(app);
    if (status != VIT_EXIT_DONE)
        return status;
    struct vit_volume *volume = app_input_open(app);
    status = volume ? app_volume_write(app, volume) : VIT_EXIT_INPUT;
    vit_volume_destroy(&volume);
    return status;
}
