/* phantom_head: a head with skin, fat, muscle, a skull with diploe, orbits, teeth, sinuses, brain and cervical spine,
 * as signed distances (mm, negative inside) to ellipsoids, capsules and rings, blended where flesh and bone have no
 * edge. A tissue is painted over what is there by how much of a voxel its distance covers, so edges are as smooth as a
 * scanner's. Made up, not measured from anybody; HU after common CT tables. Left and right are mirror images. */
#include "phantom_private.h"

#include <math.h>

enum {
    HU_AIR = -1000,
    HU_FAT = -95,
    HU_FLUID = 8,
    HU_WHITE = 28,
    HU_GREY = 38,
    HU_SKIN = 25,
    HU_MUSCLE = 55,
    HU_LENS = 85,
    HU_CARTILAGE = 150,
    HU_DIPLOE = 480, /* of the skull's roof */
    HU_SPONGY = 600,
    HU_BONE = 1150,
    HU_TOOTH = 2300,
};
#define BONE_DEPTH_MM 2.8 /* least flesh over a bone */
#define EDGE_MM       1.8 /* over which one tissue fades into the next: a voxel and a half */

typedef struct vit_vec3 vec;

/* These three are called with constants some thirty times per voxel: inlined, all but the position folds away. */

/* Distance to an ellipsoid with half axes r, exact on its surface and to first order near it (I. Quilez). */
static inline double ellipsoid(vec p, vec c, vec r)
{
    const double ix = 1 / r.x, iy = 1 / r.y, iz = 1 / r.z;
    double x = (p.x - c.x) * ix, y = (p.y - c.y) * iy, z = (p.z - c.z) * iz;
    double k0 = sqrt(x * x + y * y + z * z);
    double k1 = sqrt(x * x * ix * ix + y * y * iy * iy + z * z * iz * iz);
    return k1 > 0 ? k0 * (k0 - 1) / k1 : -1 / fmax(ix, fmax(iy, iz));
}

/* Capsule from a to b whose radius goes from ra to rb. */
static inline double capsule(vec p, vec a, vec b, double ra, double rb)
{
    const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, inverse = 1 / (dx * dx + dy * dy + dz * dz);
    double x = p.x - a.x, y = p.y - a.y, z = p.z - a.z;
    double t = (x * dx + y * dy + z * dz) * inverse;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    x -= t * dx;
    y -= t * dy;
    z -= t * dz;
    return sqrt(x * x + y * y + z * z) - (ra + (rb - ra) * t);
}

/* Ring of radius `major` around c in the plane across the unit vector `axis`. */
static inline double ring(vec p, vec c, vec axis, double major, double minor)
{
    double x = p.x - c.x, y = p.y - c.y, z = p.z - c.z;
    double along = x * axis.x + y * axis.y + z * axis.z;
    double across = sqrt(fmax(x * x + y * y + z * z - along * along, 0));
    return sqrt((across - major) * (across - major) + along * along) - minor;
}

/* Union and cut whose edge is rounded over k mm. */
static inline double join(double a, double b, double k)
{
    double h = k - fabs(a - b), least = a < b ? a : b;
    return h > 0 ? least - h * h * (0.25 / k) : least;
}
static inline double cut(double a, double b, double k)
{
    return -join(-a, b, k);
}

static void paint(double *hu, double tissue, double distance)
{
    double share = fmin(fmax(0.5 - distance / EDGE_MM, 0), 1);
    *hu += (tissue - *hu) * share;
}

/* ---- outside ---------------------------------------------------------------------------------------------- */

static const vec skull_center = {0, 8, 34};
#define DEEP_MM 25.0 /* further in than this nobody asks how far the skin is */

static double nose(vec p)
{
    double d = capsule(p, (vec){0, -83, 18}, (vec){0, -100, -18}, 5, 7.5);
    d = join(d, ellipsoid(p, (vec){7.5, -91, -22}, (vec){6.5, 9, 6}), 7);
    return cut(d, capsule(p, (vec){4.8, -98, -32}, (vec){4.5, -90, -20}, 2.6, 2.4), 2);
}

/* The cup is hollowed towards the front and leans out at the back. */
static double ear(vec p)
{
    const double c = 0.87, s = 0.49; /* 29° */
    vec q = {c * (p.x - 73) - s * (p.y - 16), s * (p.x - 73) + c * (p.y - 16), p.z + 4 - 0.12 * (p.y - 16)};
    double d = ellipsoid(q, (vec){0, 0, 0}, (vec){5.5, 17, 29});
    d = cut(d, ellipsoid(q, (vec){5.5, -1, 3}, (vec){5.5, 11, 19}), 3);
    return cut(d, ellipsoid(q, (vec){3, -6, -4}, (vec){7, 6, 8}), 3);
}

/* Brows, eyes, nose and mouth: the front of the face. */
static double features(double d, vec p)
{
    d = join(d, capsule(p, (vec){0, -80, 31}, (vec){40, -66, 31}, 6, 5), 14);
    d = cut(d, ellipsoid(p, (vec){33, -98, 11}, (vec){17, 18, 10}), 14);
    d = join(d, ellipsoid(p, (vec){33, -68, 10}, (vec){15, 12.5, 10}), 8);          /* closed eye */
    d = cut(d, ring(p, (vec){33, -72, 13}, (vec){0, -0.4, 0.916}, 11.5, 0.5), 1.5); /* its lid */
    d = join(d, nose(p), 8);
    d = join(d, ellipsoid(p, (vec){0, -66, -53}, (vec){24, 20, 4.5}), 5); /* lips */
    d = join(d, ellipsoid(p, (vec){0, -66, -62.5}, (vec){21, 20, 5}), 4);
    return cut(d, ellipsoid(p, (vec){0, -68, -57.8}, (vec){25, 20, 1.1}), 2.5);
}

static double face(vec p)
{
    double d = ellipsoid(p, (vec){0, -30, -30}, (vec){57, 54, 74});
    if (d < -DEEP_MM - 10)
        return d;
    d = join(d, ellipsoid(p, (vec){0, -66, -86}, (vec){22, 24, 17}), 16);         /* chin */
    d = join(d, capsule(p, (vec){44, -2, -56}, (vec){18, -62, -84}, 17, 13), 14); /* jaw */
    d = join(d, ellipsoid(p, (vec){48, -18, -14}, (vec){21, 46, 40}), 14);        /* temple */
    d = join(d, ellipsoid(p, (vec){42, -56, -16}, (vec){18, 22, 16}), 14);        /* cheek */
    d = join(d, ellipsoid(p, (vec){44, 14, -32}, (vec){20, 24, 28}), 14);         /* below the ear */
    return p.y < -40 ? features(d, p) : d;
}

static double skin(vec p)
{
    double d = ellipsoid(p, skull_center, (vec){74, 92, 78});
    if (d < -DEEP_MM || p.z > 70)
        return d;
    d = join(d, capsule(p, (vec){0, 26, -45}, (vec){0, 38, -170}, 49, 53), 24);
    if (d < -DEEP_MM)
        return d;
    if (p.y < 60)
        d = join(d, face(p), 18);
    if (p.x > 55 && fabs(p.y - 16) < 30 && fabs(p.z + 4) < 40)
        d = join(d, ear(p), 5);
    return d;
}

/* ---- skull ------------------------------------------------------------------------------------------------ */

/* The skull base rises towards the front: above this plane is brain, below it the face. */
static double base_plane(vec p)
{
    return -((p.y + 70) * 0.625 + (p.z - 36) * 0.781);
}

static double cavity(vec p)
{
    return cut(ellipsoid(p, skull_center, (vec){61, 79, 65.5}), -base_plane(p), 10);
}

static double cranium(vec p)
{
    double d = cut(ellipsoid(p, skull_center, (vec){67.5, 85.5, 72}), 6 - base_plane(p), 6);
    if (p.z > 25 || d < -15)
        return d;
    d = join(d, capsule(p, (vec){58, 20, -16}, (vec){16, 0, -16}, 8, 6), 6);   /* petrous part */
    d = join(d, ellipsoid(p, (vec){47, 22, -34}, (vec){10, 12, 17}), 8);       /* mastoid */
    d = join(d, ellipsoid(p, (vec){40, -20, 2}, (vec){17, 26, 21}), 12);       /* temple */
    d = join(d, ellipsoid(p, (vec){0, -18, -16}, (vec){20, 17, 13}), 8);       /* sphenoid */
    d = join(d, ellipsoid(p, (vec){15, 15, -38}, (vec){6, 9, 6}), 5);          /* condyles */
    return fmax(d, -capsule(p, (vec){0, 26, -20}, (vec){0, 28, -60}, 11, 11)); /* great hole */
}

static double orbit(vec p)
{
    return capsule(p, (vec){33, -80, 11}, (vec){14, -34, -2}, 17, 3);
}

static double nasal_cavity(vec p)
{
    return join(ellipsoid(p, (vec){0, -62, -27}, (vec){12, 33, 10}),
                ellipsoid(p, (vec){0, -60, -9}, (vec){5.5, 32, 17}), 8);
}

/* `d`: the bones behind, which these grow out of. */
static double face_bones(double d, vec p)
{
    d = join(d, ellipsoid(p, (vec){0, -47, -19}, (vec){40, 30, 28}), 8);        /* maxilla */
    d = join(d, ellipsoid(p, (vec){45, -55, -12}, (vec){12, 13, 12}), 10);      /* cheekbone */
    d = join(d, capsule(p, (vec){50, -52, -12}, (vec){62, -22, -12}, 6, 4), 6); /* its arch */
    d = join(d, capsule(p, (vec){62, -22, -12}, (vec){59, 8, -11}, 4, 5), 5);
    d = join(d, fmax(orbit(p) - 2.5, -70 - p.y), 4);                                  /* orbit's walls */
    d = join(d, ring(p, (vec){33, -70.5, 11}, (vec){0.42, -0.907, 0}, 19.5, 4.5), 7); /* and rim */
    d = join(d, capsule(p, (vec){0, -76, 33}, (vec){40, -62, 34}, 4.5, 4.5), 8);      /* brow */
    d = join(d, capsule(p, (vec){49.5, -56, 4}, (vec){51, -50, 33}, 4, 4), 6);
    d = join(d, capsule(p, (vec){0, -75, 26}, (vec){0, -86, 2}, 5, 3), 7);    /* nasal bone */
    d = join(d, capsule(p, (vec){8, -75, 24}, (vec){17, -72, -22}, 3, 4), 5); /* beside the nose */
    d = cut(d, orbit(p), 2.5);
    return cut(d, nasal_cavity(p), 2);
}

/* A capsule drawn out into a plate: `wide` times as long along y as its radius. */
static inline double plate(vec p, vec a, vec b, double radius, double wide)
{
    double y = a.y + (b.y - a.y) * (p.z - a.z) / (b.z - a.z); /* the middle line at this height */
    return capsule((vec){p.x, y + (p.y - y) / wide, p.z}, a, b, radius, radius);
}

static double mandible(vec p)
{
    double d = plate(p, (vec){52, -12, -34}, (vec){48, -16, -64}, 5, 2.6);          /* ramus */
    d = join(d, capsule(p, (vec){54, 0, -17}, (vec){51, -6, -40}, 5.5, 5), 7);      /* joint */
    d = join(d, capsule(p, (vec){50, -26, -18}, (vec){50, -20, -40}, 3, 5), 6);     /* muscle process */
    d = join(d, capsule(p, (vec){48, -14, -66}, (vec){17, -64, -83}, 8, 9), 10);    /* body */
    return join(d, capsule(p, (vec){17, -64, -83}, (vec){0, -72, -86}, 9, 9.5), 8); /* chin */
}

/* ---- teeth and their sockets ------------------------------------------------------------------------------ */

/* One dental arch: an ellipse, half axes rx and ry around (0, yc), between z0 and z1. */
struct arch {
    double rx, ry, yc;
};
static const struct arch upper = {25.5, 35, -40}, lower = {24.5, 33, -40};
#define TOOTH_RAD 0.232 /* seven teeth on a side */
#define TEETH_RAD (7 * TOOTH_RAD)

static double slab(double v, double low, double high)
{
    return fmax(low - v, v - high);
}

/* Band of the arch, `half` thick to each side. */
static double arch_band(vec p, struct arch a, double half, double *angle)
{
    double x = p.x / a.rx, y = -(p.y - a.yc) / a.ry, mean = 0.5 * (a.rx + a.ry);
    *angle = atan2(x, y);
    return fmax(fabs(hypot(x, y) - 1) * mean - half, (*angle - TEETH_RAD) * mean);
}

static double sockets(vec p, struct arch a, double low, double high)
{
    double angle;
    return fmax(arch_band(p, a, 4.5, &angle), slab(p.z, low, high));
}

static double teeth_of(vec p, struct arch a, double crown_low, double crown_high, double root_z)
{
    double angle, mean = 0.5 * (a.rx + a.ry);
    double half = 3.4, band = arch_band(p, a, half, &angle);
    double along = fabs(remainder(angle - 0.5 * TOOTH_RAD, TOOTH_RAD)) * mean;
    double neck = root_z > crown_high ? crown_high : crown_low;
    double taper = 0.09 * (10 - fabs(p.z - neck)); /* crowns are narrower where they meet the gum */
    double crown = fmax(fmax(band + taper, along - 2.9 + taper), slab(p.z, crown_low, crown_high));
    double deep = fmin(fmax((p.z - neck) / (root_z - neck), 0), 1);
    double root = fmax(fmax(band + 1.2 + 1.5 * deep, along - 2.2 + 1.2 * deep),
                       slab(p.z, fmin(neck, root_z), fmax(neck, root_z)));
    return fmin(crown, root);
}

static double teeth(vec p)
{
    return fmin(teeth_of(p, upper, -58.5, -49, -38), teeth_of(p, lower, -68.5, -59.5, -80));
}

/* ---- spine ------------------------------------------------------------------------------------------------ */

#define VERTEBRA_MM 17.0
struct spine {
    double bone, disc, canal;
};

static struct spine spine(vec p)
{
    double step = floor((p.z + 44) / VERTEBRA_MM);
    double z = p.z + 44 - (step + 0.5) * VERTEBRA_MM; /* from this vertebra's middle */
    double y = p.y - 20 - 0.10 * (-44 - p.z);
    vec q = {p.x, y, z};
    struct spine s;
    double column = (hypot(q.x / 11.5, q.y / 9.5) - 1) * 9.5;
    s.disc = fmax(column, p.z + 44);
    s.canal = fmax(hypot(q.x, q.y - 17) - 7.5, p.z + 30);
    double d = fmax(column, fabs(z) - 6.8);
    double arch = fmax(hypot(q.x, q.y - 17) - 11.5, fabs(z + 1) - 5);
    d = fmin(d, arch);
    d = join(d, ellipsoid(q, (vec){17, 9, 0}, (vec){6.5, 7, 7.5}), 4);      /* joints */
    d = join(d, capsule(q, (vec){8, 2, 0}, (vec){23, 4, -1}, 4, 3), 3);     /* across */
    d = join(d, capsule(q, (vec){0, 27, -1}, (vec){0, 42, -6}, 3.5, 3), 3); /* spine */
    s.bone = fmax(fmax(d, -s.canal), p.z + 44.5);
    return s;
}

/* ---- putting it together ---------------------------------------------------------------------------------- */

static double brain_hu(vec p, double x, double depth)
{
    /* folds: the depth at which fluid ends wavers */
    double fold = 0, hu = HU_FLUID;
    if (depth > -14)
        fold = 2.6 * sin(0.31 * p.y + 1.7 * sin(0.13 * p.z)) * sin(0.29 * p.z + 1.9 * sin(0.11 * x + 0.09 * p.y)) *
               sin(0.33 * p.x + 0.6);
    double surface = depth + 3 + fold;
    paint(&hu, HU_GREY, surface);
    paint(&hu, HU_WHITE, surface + 5);
    if (p.z > 22)
        paint(&hu, 60, fmax(p.x - 0.8, fmax(12 - hypot(p.y - 8, p.z - 22) * 0.25, depth))); /* falx */
    if (depth > -10)
        return hu;
    paint(&hu, HU_GREY, ellipsoid(p, (vec){16, 4, 20}, (vec){10, 18, 11})); /* deep nuclei */
    paint(&hu, HU_FLUID, ellipsoid(p, (vec){9, 4, 38}, (vec){5.5, 31, 9})); /* ventricles */
    paint(&hu, HU_FLUID, ellipsoid(p, (vec){0, 8, 20}, (vec){2.5, 13, 9}));
    return hu;
}

/* Filled with air, or lined; the sinuses keep a wall of `bone` around them. */
static void paint_hollows(double *hu, vec p, double outside, double bone)
{
    double nasal = fmax(nasal_cavity(p), outside + 3);
    paint(hu, HU_AIR, nasal);
    paint(hu, HU_CARTILAGE, fmax(nasal, p.x - 1)); /* septum */
    paint(hu, HU_MUSCLE, fmax(nasal, ellipsoid(p, (vec){7.5, -52, -27}, (vec){3, 22, 5})));
    paint(hu, HU_AIR, capsule(p, (vec){4.8, -98, -32}, (vec){4.5, -88, -22}, 2.6, 2.4)); /* nostrils */
    double sinus =
        fmin(ellipsoid(p, (vec){27, -50, -20}, (vec){11, 17, 15}), ellipsoid(p, (vec){0, -21, -15}, (vec){12, 11, 8}));
    sinus = fmin(sinus, ellipsoid(p, (vec){9, -74, 37}, (vec){9, 4, 7}));
    double cells = fmax(ellipsoid(p, (vec){47, 22, -34}, (vec){8, 10, 14}),
                        2 - 10 * sin(0.9 * p.x) * sin(0.8 * p.y) * sin(0.85 * p.z));
    paint(hu, HU_AIR, fmax(sinus, bone + 1.8));
    paint(hu, -500, fmax(cells, bone + 2.5));
    double throat = fmin(capsule(p, (vec){0, -32, -30}, (vec){0, -6, -48}, 8, 8),
                         capsule(p, (vec){0, -6, -48}, (vec){0, 2, -170}, 8, 8));
    paint(hu, HU_AIR, throat);
    paint(hu, HU_AIR, capsule(p, (vec){80, 12, -6}, (vec){44, 10, -8}, 3.5, 2.5)); /* ear canal */
}

static void paint_eye(double *hu, vec p)
{
    double in_orbit = orbit(p);
    if (in_orbit > 2)
        return;
    paint(hu, HU_FAT, fmax(in_orbit + 1.5, -75 - p.y));
    paint(hu, HU_MUSCLE, capsule(p, (vec){33, -58, 11}, (vec){14, -34, -2}, 2, 2)); /* nerve */
    double eye = ellipsoid(p, (vec){33, -70, 11}, (vec){12, 12, 12});
    paint(hu, 45, eye);
    paint(hu, HU_FLUID + 4, eye + 1.2);
    paint(hu, HU_LENS, ellipsoid(p, (vec){33, -78, 11}, (vec){4.5, 2.2, 4.5}));
}

/* Compact bone with spongy bone inside; `inner`: distance to the brain's cavity. Painted once per place: fading in
 * twice would make edges uneven. */
static void paint_bone(double *hu, double bone, double inner, double spongy)
{
    paint(hu, HU_BONE, bone);
    paint(hu, spongy, fmax(bone + 2.2, 2.2 - inner));
}

/* From the brows down: spine, face, jaw, teeth. */
static void paint_lower(double *hu, vec p, double outside, double bone, double inner)
{
    if (p.z < -28 && p.y > 0) {
        struct spine s = spine(p);
        paint(hu, 90, s.disc);
        paint(hu, HU_BONE, s.bone);
        paint(hu, 350, s.bone + 2);
        paint(hu, HU_FLUID, s.canal);
        paint(hu, HU_GREY, s.canal + 3);
    }
    if (p.y > 40) {
        paint_bone(hu, bone, inner, HU_SPONGY);
        return;
    }
    paint_eye(hu, p);
    bone = fmax(join(face_bones(bone, p), sockets(p, upper, -49, -36), 6), outside + BONE_DEPTH_MM);
    paint_bone(hu, bone, inner, HU_SPONGY);
    if (p.z < -10) {
        double jaw = join(mandible(p), sockets(p, lower, -84, -69), 6);
        paint_bone(hu, fmax(jaw, outside + BONE_DEPTH_MM), inner, HU_SPONGY);
    }
    paint_hollows(hu, p, outside, bone);
    if (p.z < -30 && p.z > -85)
        paint(hu, HU_TOOTH, teeth(p));
}

double vit_phantom_head_hu(vec mm, vec half_mm)
{
    (void)half_mm;
    const vec p = {fabs(mm.x), mm.y, mm.z};
    double hu = HU_AIR, outside = skin(p);
    if (outside > EDGE_MM)
        return hu;
    paint(&hu, HU_SKIN, outside);
    paint(&hu, HU_FAT, outside + 2);
    paint(&hu, HU_MUSCLE, outside + (p.z > 20 ? 4.5 : 6));
    double inner = cavity(p);
    if (inner > -EDGE_MM) {
        double bone = cranium(p);
        if (p.z < 50)
            paint_lower(&hu, p, outside, bone, inner);
        else
            paint_bone(&hu, bone, inner, HU_DIPLOE);
    }
    if (inner < EDGE_MM)
        paint(&hu, brain_hu(p, mm.x, inner), inner);
    return hu;
}
