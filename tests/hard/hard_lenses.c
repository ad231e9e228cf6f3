// Hard cases of lenses and shutters.
#include "hard/hard.h"
#include "scene/lens.h"

#include <math.h>

static void lens_0( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
        rf_set_lens( h->eyes + i, 0.0, i % 2 == 0 ? 0.0 : INFINITY, 0, 0.0 );
}

static void lens( HardScene* h, float scale, double radius, double focus )
{
    hard_stage( h, hard_glossy() );
    hard_move( h, scale, rf_vec3( 0, 0, 0 ) );
    for ( int i = 0; i < 7; ++i )
        rf_set_lens( h->eyes + i, radius, focus, i == 4 ? 5 : 0, 0.3 );
    h->spp = 14; // each pass has one point of the lens
}

// On a stage of 40 km, focused on the block.
static void lens_1e3( HardScene* h ) { lens( h, 1e4f, 1e3, 2.2e4 ); }
static void lens_1e3_in_a_room( HardScene* h ) { lens( h, 1.0f, 1e3, 2.2 ); }
static void focus_infinite( HardScene* h ) { lens( h, 1.0f, 0.05, INFINITY ); }
static void focus_near( HardScene* h ) { lens( h, 1.0f, 0.01, 1e-6 ); }

static void shutter_0( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
    {
        RfEye still = h->eyes[i];
        rf_set_shutter( h->eyes + i, &still, &still );
    }
}

const HardCase g_hard_lenses[] = {
    { "lens-0", "lenses of radius 0, focused at 0 and at infinity", "0/0 in the shear of the film", HARD_DOUBLE, 1.5, lens_0,
      NULL },
    { "lens-1e3", "a lens of 1 km, focused at 22 km", "films sheared by 1 px and more", HARD_DOUBLE, 1.5, lens_1e3, NULL },
    { "lens-1e3-in-a-room", "a lens of 1 km in a room of 4 m", "films sheared by 1e4 px", HARD_FINITE, 0, lens_1e3_in_a_room,
      NULL },
    { "focus-infinite", "a lens focused at infinity", "inf in the shear of the film", HARD_DOUBLE, 1.5, focus_infinite, NULL },
    { "focus-1e-6", "a lens focused at 1e-6 m", "films sheared by 1e5 px", HARD_FINITE, 0, focus_near, NULL },
    { "shutter-0", "a shutter that is open for no time", "three equal poses", HARD_DOUBLE, 1.5, shutter_0, NULL },
    { 0 },
};
