// Hard cases of what moves or changes: rooms of support/moving_rooms.py, whose pictures are those of the still room of the frame.
#include "hard/hard_inputs.h"
#include "scene/light_groups.h"
#include "support/moving_rooms.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// The first frames of its path, `most` of them.
static void load_frames( HardScene* h, const char* name, int most )
{
    MovingRoom room = load_moving_room( name, HARD_WIDTH, HARD_HEIGHT );
    h->scene = room.scene;
    h->eye_count = room.eye_count < most ? room.eye_count : most;
    memcpy( h->eyes, room.eyes, sizeof room.eyes );
    h->still = load_still_room( name, h->eye_count / 2, HARD_WIDTH, HARD_HEIGHT ).scene;
}

static void load( HardScene* h, const char* name ) { load_frames( h, name, MOVING_EYES ); }

static void sweep( HardScene* h ) { load( h, "sweep" ); }
static void lid( HardScene* h ) { load( h, "shown" ); }
static void around_eye( HardScene* h ) { load( h, "around-eye" ); }
static void flat( HardScene* h ) { load( h, "flat" ); }
static void singular( HardScene* h ) { load( h, "singular" ); }
static void late( HardScene* h ) { load( h, "late" ); }
static void no_area( HardScene* h ) { load( h, "no-area" ); }

// The lenses would be as large as the scene.
static void far_out( HardScene* h )
{
    load( h, "far-out" );
    h->sharp = true;
}

static void plate( HardScene* h ) { load( h, "plate" ); }

static void short_path( HardScene* h )
{
    load_frames( h, "short-path", 3 );
    h->group = 1 << 20;
}

static void dimmer( HardScene* h ) { load( h, "dimmer" ); }
static void blackout( HardScene* h ) { load( h, "blackout" ); }
static void jumps( HardScene* h ) { load( h, "jumps" ); }
static void extremes( HardScene* h ) { load( h, "extremes" ); }
static void sinks( HardScene* h ) { load( h, "sinks" ); }
static void horizon( HardScene* h ) { load( h, "horizon" ); }
static void shrinks( HardScene* h ) { load( h, "shrinks" ); }
static void polishes( HardScene* h ) { load( h, "polishes" ); }

// What lamps of each primary light, in a group of that name.
static void tag_primary( RfScene* scene, RfVec3 light, uint16_t* tag )
{
    const char* name = light.x > 0.0f ? "red" : light.y > 0.0f ? "green" : "blue";
    if ( rf_max_component( light ) > 0.0f && !rf_tag_light( scene, name, tag ) )
        abort();
}

// The mean errors of a frame's groups: of the primary of each, which is the picture's, and of the others, which are black.
typedef struct PrimaryErrors
{
    int groups;
    double of_own, of_others, brightness;
} PrimaryErrors;

static RfResult compare_primaries( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    PrimaryErrors* e = user;
    int values = 3 * HARD_WIDTH * HARD_HEIGHT;
    for ( int i = 0; i < values; ++i )
        e->brightness += fabs( (double)frame->rgb[i] ) / values;
    for ( int g = 0; g < frame->layer_count; ++g )
    {
        static const char* const names[] = { "light_red", "light_green", "light_blue" };
        for ( int i = 0; i < values; ++i )
        {
            bool own = strcmp( frame->layers[g].name, names[i % 3] ) == 0;
            double off = (double)frame->layers[g].values[i] - ( own ? (double)frame->rgb[i] : 0.0 );
            *( own ? &e->of_own : &e->of_others ) += fabs( off ) / values;
        }
    }
    e->groups = frame->layer_count;
    return RF_OK;
}

// A light group of lamps of one primary is that channel of the picture, whatever moves, is dimmed or seen by mirrors.
static HardInput primaries( void )
{
    HardInput out = { 0 };
    MovingRoom room = load_moving_room( "primaries", HARD_WIDTH, HARD_HEIGHT );
    for ( int i = 0; i < room.scene.punctual_count; ++i )
        tag_primary( &room.scene, room.scene.punctuals[i].intensity, &room.scene.punctuals[i].light_group );
    for ( uint32_t i = 0; i < room.scene.material_count; ++i )
        tag_primary( &room.scene, room.scene.materials[i].emission, &room.scene.materials[i].light_group );
    AUTO_TRACER tracer = make_tracer( &room.scene );
    RfRenderSettings settings = plain_settings();
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    settings.light_groups = "all";
    settings.group = 3;
    settings.spp = 7;
    settings.threads = 1;
    settings.memory = (size_t)256 << 20;
    rf_parse_tile( "3x3", &settings.tile );
    PrimaryErrors e = { 0 };
    RfRenderCallbacks callbacks = { .user = &e, .frame = compare_primaries };
    RfError error = { 0 };
    int frame = room.eye_count / 2;
    RfResult result =
        rf_render( &( RfShot ){ tracer, room.eyes, room.eye_count, &frame, 1 }, &settings, &callbacks, NULL, &error );
    rf_destroy_scene( &room.scene );
    if ( result != RF_OK )
        HARD_TELL( "%s", error.text );
    out.holds = e.groups == 3 && e.brightness > 0.0 && e.of_own <= 1e-6 * e.brightness && e.of_others == 0.0;
    HARD_TELL( "%d groups, their own primary off by %.2g of a brightness of %.2g, of others %.2g", e.groups, e.of_own,
               e.brightness, e.of_others );
}

const HardCase g_hard_moving[] = {
    { "moves-sweep", "a panel passes between lamp, wall and eye", "hits that its frame alone sees", HARD_PLAIN, 3.0, sweep,
      NULL },
    { "moves-lid", "a lid covers the lamp in some frames", "light of other frames", HARD_PLAIN, 3.0, lid, NULL },
    { "moves-around-eye", "a box is around the eye in one frame", "hits of frames that see past it", HARD_PLAIN, 1.5, around_eye,
      NULL },
    { "moves-flat", "scales of 0 along one axis and all", "matrices without an inverse", HARD_PLAIN, 1.5, flat, NULL },
    { "moves-singular", "a skin whose joints have scales of 0", "normals of length 0", HARD_PLAIN, 1.5, singular, NULL },
    { "moves-late", "nothing stands still, nor is there in the first frame", "a scene without triangles or bounds", HARD_PLAIN,
      1.5, late, NULL },
    { "moves-no-area", "triangles without an area move", "normals of length 0", HARD_PLAIN, 1.5, no_area, NULL },
    { "moves-far-out", "things go 1e6 m away and come back", "bounds, offsets", HARD_PLAIN, 1.5, far_out, NULL },
    { "moves-short-path", "a group of 2097153 in a path of 3 frames", "worlds of frames that are not", HARD_PLAIN, 1.5,
      short_path, NULL },
    { "moves-plate", "a plate covers the sun from 9 km above, for a moment", "rays to the sun that end before", HARD_PLAIN, 1.5,
      plate, NULL },
    { "changes-dimmer", "a lamp is dimmed", "light of other frames", HARD_PLAIN, 1.5, dimmer, NULL },
    { "changes-blackout", "all light is dimmed to nothing in one frame", "light of other frames, 0/0 in its scale", HARD_BLACK,
      0.0, blackout, NULL },
    { "changes-jumps", "a lamp is elsewhere in one frame", "light of other frames", HARD_PLAIN, 3.0, jumps, NULL },
    { "changes-extremes", "a lamp of 1e-30 to 1e9 W/sr", "scales of 1e-39; lights are selected by the most of the group",
      HARD_PLAIN, 20.0, extremes, NULL },
    { "changes-sinks", "a lamp sinks through a surface", "the lamp is 1 mm from it: few samples hold the error", HARD_PLAIN, 0.0,
      sinks, NULL },
    { "changes-horizon", "the sun is at the horizon", "cosines of 0", HARD_PLAIN, 3.0, horizon, NULL },
    { "changes-shrinks", "what shines shrinks to a point and to nothing", "lights without an area", HARD_PLAIN, 3.0, shrinks,
      NULL },
    { "changes-primaries", "light groups of one primary each: dimmed, passing, by a mirror", "light in another group", HARD_INPUT,
      0.0, NULL, primaries },
    { "changes-polishes", "the roughness of a metal is 0 in one frame", "a mirror in the frame alone", HARD_PLAIN, 3.0, polishes,
      NULL },
    { 0 },
};
