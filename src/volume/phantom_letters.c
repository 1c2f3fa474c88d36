/* phantom_letters: a cube with a letter on each face, upright and unmirrored when that face is looked at with the view
 * of its name (ARCHITECTURE, Geometry). Every letter has an HU of its own and a full stop at its lower right, so that
 * A and I too tell left from right and up from down. */
#include "phantom_private.h"

#include <math.h>

#define BODY_HU   200.0
#define BODY_HALF 0.75       /* of the box's half edge */
#define RAISED    (1.0 / 12) /* the letters stand out of the body by this, of the half edge */
#define SUNK      (1.0 / 12) /* and go as deep into it */
#define CELL      (1.0 / 6)  /* side of a dot of the letters: 8 voxels of 48 */
#define COLUMNS   7
#define ROWS      7

/* One face: where the camera is, and which way is right and up on the screen. */
struct face {
    struct vit_vec3 toward, right, up;
    double hu;
    const char *rows[ROWS];
};
/* clang-format off */
static const struct face faces[6] = {
    {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, 1000, {"####   ", "#   #  ", "#   #  ", "####   ", "# #    ", "#  #   ", "#   # #"}},
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1200,   {"#      ", "#      ", "#      ", "#      ", "#      ", "#      ", "##### #"}},
    {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, 1400,  {" ###   ", "#   #  ", "#   #  ", "#####  ", "#   #  ", "#   #  ", "#   # #"}},
    {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, 1600,  {"####   ", "#   #  ", "#   #  ", "####   ", "#      ", "#      ", "#     #"}},
    {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1800,   {" ####  ", "#      ", "#      ", " ###   ", "    #  ", "    #  ", "####  #"}},
    {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}, 2000, {"#####  ", "  #    ", "  #    ", "  #    ", "  #    ", "  #    ", "##### #"}},
};
/* clang-format on */

static bool in_letter(const struct face *face, struct vit_vec3 p)
{
    /* Row 0 is the top one. */

    int column = (int)floor(vit_vec3_dot(p, face->right) / CELL + 0.5 * COLUMNS);
    int row = (int)floor(0.5 * ROWS - vit_vec3_dot(p, face->up) / CELL);
    return column >= 0 && column < COLUMNS && row >= 0 && row < ROWS && face->rows[row][column] == '#';
}

double vit_phantom_letters_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    const struct vit_vec3 p = {mm.x / half.x, mm.y / half.y, mm.z / half.z};
    for (int f = 0; f < 6; f++) {
        double depth = BODY_HALF + RAISED - vit_vec3_dot(p, faces[f].toward);
        if (depth >= 0 && depth < RAISED + SUNK && in_letter(&faces[f], p))
            return faces[f].hu;
    }
    bool in_body = fabs(p.x) <= BODY_HALF && fabs(p.y) <= BODY_HALF && fabs(p.z) <= BODY_HALF;
    return in_body ? BODY_HU : -1000;
}
