// Faults, for the hard cases: a build with -DREFRAME_FAULTS=ON takes out the protection that the environment variable
// REFRAME_FAULT names, and scripts/hard-cases sees to it that a hard case then fails. In every other build RF_FAULT is a
// constant 0, which costs nothing.
#ifndef REFRAME_BASE_FAULT_H
#define REFRAME_BASE_FAULT_H

// X( name, what protects, the cases of tests/hard that fail without it )
// clang-format off
#define RF_FAULTS( X ) \
    X( all_weights_0, "a reconstruction whose weights are all 0 is refused", "poisson-zero-weights" ) \
    X( behind_the_eye, "what is behind a camera is not seen", "path-turns" ) \
    X( below_triangle, "no light comes from below the triangle, whatever its shading normal", "leaning-normals" ) \
    X( coat_horizon, "what is below the horizon of a coat is not lit by it", "clear-coat-grazing" ) \
    X( cubed_cosine, "the film density has the cube of the cosine at the camera", "angle-170" ) \
    X( delta_pdf, "delta lobes have a finite density: no inf/inf in the weights", "mirror mirror-grazing mirror-edge-on mirror-stage ior-10 absorption-1e-9" ) \
    X( density_divisor, "no division by a depth, or its cube, that is 0 in floats", "density-beyond-floats subnormals eye-on-surface eyes-in-plane path-through-wall" ) \
    X( diagonal_0, "pixels that nothing ties to data keep their value", "poisson-open" ) \
    X( embree_scale, "Embree gets scenes of ordinary size: its products of four lengths stay within floats", "scale-1e-12 acne-and-leaks" ) \
    X( empty_ball, "no 1/0 for a scene without extent", "nothing-there" ) \
    X( empty_half, "a half of the film without samples has no quotient", "one-sample" ) \
    X( eye_in_doubles, "the axes of a camera come from products in doubles", "eye-frames path-gimbal" ) \
    X( eye_rounding, "hits are lifted by the rounding of the cameras that look for them", "eyes-far-away" ) \
    X( far_filter, "rays do not find the far triangle that they leave", "far-ground" ) \
    X( far_triangles, "hits near the camera on triangles that reach far are computed in doubles", "far-ground touching-plates" ) \
    X( film_place, "positions are turned into pixels on the film only", "film-corners density-range lens-1e3 path-through-wall" ) \
    X( finite_variance, "variances beyond floats give no weights: the samples are the picture then", "radiance-1e30" ) \
    X( fixed_offset, "offsets of rays are relative to coordinates", "acne-and-leaks" ) \
    X( flat_matrix, "a matrix without an inverse moves the vertices, not the rays", "moves-flat" ) \
    X( focus_order, "the shear of a film is x / focus, which is 0 for an infinite focus", "focus-infinite" ) \
    X( swept, "light that something moving touches in the group is of its own frame", "moves-lid" ) \
    X( swept_of_group, "what moves touches light where it is in all frames of the group", "moves-lid" ) \
    X( ggx_across, "sines of sharp lobes come from a cross product", "sharp-lobes" ) \
    X( glass_no_density, "no 0/0 for directions that rough reflection cannot take", "rough-glass-grazing rough-glass" ) \
    X( group_in_path, "groups have no more frames than the path", "group-beyond-path moves-short-path" ) \
    X( half_clamp, "values beyond 65504 are clamped in half floats", "halves-beyond-65504" ) \
    X( hemisphere, "a Phong lobe ends at 90 degrees from its axis, also for exponent 0", "phong-0" ) \
    X( horizon, "directions below the horizon of a shading normal are lifted to it", "leaning-normals" ) \
    X( importance_sums, "importances are added in doubles", "light-intervals" ) \
    X( lamp_bright, "lamps too bright for a float keep the ratio of radiance and density", "lamps-1e-6" ) \
    X( lamp_infinite, "light beyond floats adds nothing, and is scaled first", "lamp-on-surface" ) \
    X( largest_density, "densities are at most 1e30: no inf/inf where a camera touches a surface", "density-range" ) \
    X( least_alpha, "the roughness of files is at least that of the least alpha", "ggx-0 ggx-0-stage" ) \
    X( least_density, "densities are at least 1e-24, also where they are NaN: their quotients stay finite", "grazing-tilted density-range" ) \
    X( least_sheen, "the roughness of sheen in files is at least that of the least alpha", "sheen-0 sheen-0-grazing" ) \
    X( lens_sharp, "a focus of 0 matters only to a lens with a radius", "lens-0" ) \
    X( light_group, "light without a part of its own counts in its light group", "changes-primaries" ) \
    X( light_offset, "shadow rays end off the light", "lights-1e-12-1e6 lights-without-area coincident" ) \
    X( light_rounding, "shadow rays end off the light by the rounding of both ends", "lamp-at-origin" ) \
    X( long_sums, "the mean is taken out of sums of many passes", "long-sums" ) \
    X( mirrored_eye, "a coat that light comes through sees the mirror image of the eye", "sheet-between-eyes" ) \
    X( mixture, "directions that nobody could have drawn bring no light", "phong-1e7 phong-1e4" ) \
    X( near_0, "rays find what is at any distance: there is no near limit", "eyes-touch-surface corner-1e-12 touching-plates" ) \
    X( neighbour_world, "cameras see hits in the world of their own frame", "moves-sweep moves-around-eye moves-far-out" ) \
    X( no_lobe, "no 0/0 in the choice of lobes of a black surface", "black" ) \
    X( no_power, "no 0/0 where all lights are black", "no-light" ) \
    X( no_reflection, "no 0/0 in the choice of reflection or transmission", "ior-1-black" ) \
    X( normalised_frames, "weights of frames sum to 1", "path-repeats eyes-coincide eyes-1e-6-apart path-stands-still group-beyond-path path-jumps eye-on-surface eyes-in-plane eyes-behind grazing-1e-5 grazing-beside-steep path-through-wall shutter-0 lens-0 lens-1e3 focus-infinite one-pixel lens-1e3-in-a-room focus-1e-6 moves-late" ) \
    X( normalised_tiles, "weights of a tile sum to 1", "depth-edges fan path-turns ggx-1 lambert-1 sheet angle-1 grazing-1e-2" ) \
    X( occlusion, "cameras do not see through walls", "eye-inside dark-room dark-room-1e-6 dark-room-1e6" ) \
    X( own_lights, "light of lamps that move or change is of its own frame", "changes-jumps" ) \
    X( own_pixel, "a hit counts in the pixel that it was drawn in, whatever rounding does to its projection", "film-16384x1" ) \
    X( part_scales, "light of dimmed lamps is scaled to the frame", "changes-dimmer changes-blackout changes-extremes" ) \
    X( phong_angle, "1 - cos comes from what is perpendicular, not from a difference", "sharp-lobes" ) \
    X( phong_sample, "directions of sharp lobes are drawn by 1 - cos", "sharp-lobes" ) \
    X( poisson_scale, "reconstructions are scaled to 1", "poisson-scaled" ) \
    X( pow_one_minus, "a power of a cosine comes from 1 - cos", "sharp-lobes" ) \
    X( radiance_scale, "sheets, which have no inside, do not scale radiance", "ior-10" ) \
    X( ray_offset, "rays start off their surface, by more than the rounding of coordinates", "acne-and-leaks scale-1e6 moved-1e6 scale-1e-6 duplicates coincident dark-ball fan degenerate" ) \
    X( roulette_0, "no 0/0 where the roulette ends all paths", "absorption-1e9" ) \
    X( rounding, "renders round to nearest, whatever mode they are called in", "rounding-modes" ) \
    X( selection, "light that is hit counts by the probability that sampling selects it", "powers-1e12" ) \
    X( shading_normal, "normals that are 0 or face into the surface are replaced", "zero-normals flipped-normals" ) \
    X( sides, "a hit is seen from its own side alone", "eyes-behind sheet" ) \
    X( sky_neighbours, "pixels of a sky are drawn by their interpolated light", "sky-one-texel" ) \
    X( sky_reach, "rays to the sky pass all that moves, however far out", "moves-plate" ) \
    X( snell, "Snell's law from the squared cosine, which has all its digits at grazing angles", "ior-1" ) \
    X( total_reflection, "no root of a negative number at total reflection", "rough-glass absorption-1e-9 ior-1.0001 ior-10-body absorption-1e9 rough-glass-grazing" ) \
    X( twins, "of lights of the same corners, one is left", "lights-in-one-place" ) \
    X( two_sided, "lights that shine to both sides are seen from behind", "in-an-emitter" ) \
    X( typical, "no 0/0 in the mean of variances that are all below floats", "radiance-1e-30" ) \
    X( unit_cross, "normals of tiny and huge triangles come from products in doubles", "scale-1e-12 scale-1e12 acne-and-leaks" ) \
    X( unit_cross_0, "triangles without area have no normal: no 1/0", "degenerate" ) \
    X( usable_eyes, "cameras that are not finite are refused", "focus-0" ) \
    X( zero_data, "no 0/0 in the residual of data that are 0", "poisson-equal" )
// clang-format on

#ifdef REFRAME_FAULTS

typedef enum RfFault
{
    RF_FAULT_none,
#define RF_FAULT_ENUM( name, what, cases ) RF_FAULT_##name,
    RF_FAULTS( RF_FAULT_ENUM )
#undef RF_FAULT_ENUM
} RfFault;

// That of REFRAME_FAULT; read when the program starts, which a name that the table lacks ends.
extern RfFault g_rf_fault;

// Whether the protection is taken out.
#define RF_FAULT( name ) ( g_rf_fault == RF_FAULT_##name )

#else
#define RF_FAULT( name ) 0
#endif

#endif
