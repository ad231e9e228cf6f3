// The lights of the groups along a path, and a pilot of their light.
#include "render/sharing.h"

#include "light/changing.h"
#include "render/settings.h"
#include "render/worlds.h"
#include "scene/movement.h"
#include "scene/projection.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

#define PILOT_RUNS 8
#define LEAST_RUNS 2 // where much is posed and lit for each
#define MOST_LIT 1e6 // triangles that are posed, and lights that move, in all runs of the pilot: about ten seconds
#define PILOT_SPP 4
#define PILOT_PATHS 240000 // in all
#define PILOT_WIDTH 48     // at most
#define LEAST_PIXELS 96    // of a film
#define MOST_ALONE 64      // lights; the others are lit together, by how they are shared
#define MOST_POSED 20e6    // triangles that are posed, over all frames: about two seconds

const char* rf_shared_name( RfShared shared )
{
    static const char* const s_names[RF_SHARED_WAYS] = { "shared", "scaled", "own-frame" };
    return s_names[shared];
}

void rf_sharing_film( double aspect, int lights, int* width, int* height )
{
    int pictures = ( lights < MOST_ALONE ? lights : MOST_ALONE + 2 ) + 1;
    double pixels = fmax( (double)PILOT_PATHS / ( PILOT_RUNS * PILOT_SPP * pictures ), LEAST_PIXELS );
    double wide = fmin( sqrt( pixels * aspect ), PILOT_WIDTH ), tall = fmin( wide / aspect, PILOT_WIDTH );
    *width = (int)fmax( wide, 1.0 );
    *height = (int)fmax( tall, 1.0 );
}

typedef struct Look
{
    const RfTracer* tracer;
    const RfCameraPath* path;
    const RfScene* scene; // as loaded
    const RfLights* lights;
    const RfRenderSettings* settings;
    const RfChanging* changing;
    int count;
    RfSharing* sharing;
    int32_t* item; // of each light: index into `changing`; −1: it does not change
    int* slot;     // of each of `changing`: the picture that has its light in the frame at hand
    RfShared* way; // likewise
    RfWorlds worlds;
    bool* moving; // by pixel
} Look;

static RfResult fail_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for how light is shared" );
}

// The item of each light, by those of materials and punctual lights. `of`: room for all of them.
static void number_items_by( Look* look, int32_t* of )
{
    const RfChangingLights* changing = look->lights->changing;
    int32_t *of_material = of, *of_punctual = of + look->scene->material_count, sky = -1;
    for ( uint32_t i = 0; i < look->scene->material_count + (uint32_t)look->lights->punctual_count; ++i )
        of[i] = -1;
    for ( int i = 0; i < look->count; ++i )
    {
        const RfChanging* c = look->changing + i;
        if ( c->shines )
            *( c->kind == RF_CHANGING_SKY ? &sky : ( c->kind == RF_CHANGING_LIGHT ? of_punctual : of_material ) + c->number ) = i;
    }
    for ( uint32_t i = 0; i < changing->count; ++i )
    {
        uint32_t light = changing->light[i].number, triangles = look->lights->triangle_count;
        look->item[light] = light >= triangles ? of_punctual[light - triangles]
                                               : of_material[rf_material_of( look->scene, look->lights->light[light].triangle )];
    }
    if ( rf_has_sky( look->lights ) )
        look->item[rf_sky_number( look->lights )] = sky;
}

static RfResult number_items( Look* look, RfError* error )
{
    size_t size = (size_t)look->scene->material_count + (size_t)look->lights->punctual_count + 1;
    for ( uint32_t i = 0; i < look->lights->count; ++i )
        look->item[i] = -1;
    if ( look->lights->changing == NULL )
        return RF_OK;
    int32_t* of = malloc( size * sizeof *of );
    if ( of == NULL )
        return fail_memory( error );
    number_items_by( look, of );
    free( of );
    return RF_OK;
}

// Light that has parts by frame is shared, whatever it is in each.
static RfShared way_of( const RfLights* lights, int part )
{
    if ( part == 0 || ( rf_is_own_part( part ) && lights->frame_count > 0 ) )
        return RF_SHARED_AS_IT_IS;
    return rf_is_own_part( part ) ? RF_SHARED_NOT : RF_SHARED_SCALED;
}

// How each that shines is shared in a group, by the light of it that is shared least.
static void find_ways( Look* look, const RfLights* lights )
{
    for ( int i = 0; i < look->count; ++i )
        look->way[i] = RF_SHARED_AS_IT_IS;
    for ( uint32_t i = 0; i < lights->count; ++i )
    {
        RfShared way = way_of( lights, rf_light_part( lights, i ) );
        if ( look->item[i] >= 0 && way > look->way[look->item[i]] )
            look->way[look->item[i]] = way;
    }
}

// Poses of the path, of which those of a group are held at once. A run is a frame, or several that are the same.
typedef struct Poses
{
    int held;
    int* run; // −1: none yet
    RfPosedScene* pose;
    RfVec3* emission; // of each, `dims` of them
    size_t dims;
} Poses;

static RfResult pose_run( const Look* look, int run, Poses* poses, RfError* error )
{
    int k = run % poses->held;
    if ( poses->run[k] == run )
        return RF_OK;
    RfResult result = rf_pose_scene( look->scene, look->path->runs[run].time, poses->pose + k, error );
    poses->run[k] = run;
    if ( result == RF_OK )
        rf_note_emission( look->lights, &poses->pose[k].scene, poses->emission + poses->dims * (size_t)k );
    return result;
}

// The ways in the group around a run.
static RfResult look_at_group( Look* look, const RfGroupPlan* plan, int run, Poses* poses, RfError* error )
{
    int first, count = 2 * look->settings->group + 1;
    RfResult result = RF_OK;
    RfGroupLights* group = NULL;
    RfLitFrame* frames = malloc( (size_t)count * sizeof *frames );
    if ( frames == NULL )
        return fail_memory( error );
    rf_frames_around( plan, run, &first, &count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        int k = ( first + i ) % poses->held;
        result = pose_run( look, first + i, poses, error );
        frames[i] = ( RfLitFrame ){ &poses->pose[k].scene, poses->emission + poses->dims * (size_t)k };
    }
    if ( result == RF_OK )
        result = rf_create_group_parts( look->lights, look->scene, count, frames, &group, error );
    if ( result == RF_OK )
        find_ways( look, group->lights );
    rf_destroy_group_lights( group );
    free( frames );
    return result;
}

static RfResult open_poses( const Look* look, Poses* poses, RfError* error )
{
    poses->held = 2 * look->settings->group + 1;
    poses->dims = look->lights->changing != NULL ? look->lights->changing->dim_count : 0;
    poses->run = malloc( (size_t)poses->held * sizeof *poses->run );
    poses->pose = calloc( (size_t)poses->held, sizeof *poses->pose );
    poses->emission = malloc( ( (size_t)poses->held * poses->dims + 1 ) * sizeof *poses->emission );
    for ( int i = 0; i < poses->held && poses->run != NULL; ++i )
        poses->run[i] = -1;
    return poses->run != NULL && poses->pose != NULL && poses->emission != NULL ? RF_OK : fail_memory( error );
}

static void close_poses( Poses* poses )
{
    for ( int i = 0; i < poses->held && poses->pose != NULL; ++i )
        rf_destroy_pose( poses->pose + i );
    free( poses->run );
    free( poses->pose );
    free( poses->emission );
}

static int runs_to_look_at( const Look* look )
{
    int runs = look->path->run_count, group = 2 * look->settings->group + 1;
    double posed = (double)rf_pose_parts( look->scene ).triangles + 2000.0;
    if ( posed * runs <= MOST_POSED )
        return runs;
    int some = (int)( MOST_POSED / ( posed * group ) ), least = runs < PILOT_RUNS ? runs : PILOT_RUNS;
    return some < least ? least : some < runs ? some : runs;
}

// How many of those have pictures, each with a BVH and a tree of all lights.
static int runs_to_light( const Look* look, int looked )
{
    double each = (double)rf_pose_parts( look->scene ).triangles + (double)rf_count_moving_emitters( look->scene ) + 1.0;
    int some = MOST_LIT / each < PILOT_RUNS ? (int)( MOST_LIT / each ) : PILOT_RUNS;
    some = some > LEAST_RUNS ? some : LEAST_RUNS;
    return looked < some ? looked : some;
}

// The k-th of some of them.
static int pick( int k, int some, int all ) { return (int)( ( 2 * (int64_t)k + 1 ) * all / ( 2 * some ) ); }

// The pilot.

typedef struct Lit
{
    const Look* look;
    int slot; // −1: of what does not change
} Lit;

static bool is_in_slot( void* user, uint32_t light )
{
    const Lit* lit = user;
    int32_t item = lit->look->item[light];
    return ( item < 0 ? -1 : lit->look->slot[item] ) == lit->slot;
}

// Lights that change have a picture each, as long as they are few.
static int number_slots( Look* look )
{
    int alone = 0;
    for ( int i = 0; i < look->count; ++i )
    {
        if ( look->changing[i].shines )
            look->slot[i] = alone < MOST_ALONE ? alone++ : MOST_ALONE + (int)look->way[i];
    }
    return alone < MOST_ALONE ? alone : MOST_ALONE + RF_SHARED_WAYS;
}

static RfRenderSettings pilot_settings( const Look* look )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.group = 0;
    settings.spp = PILOT_SPP;
    settings.filter = RF_FILTER_BOX;
    settings.filter_width = rf_default_filter_width( RF_FILTER_BOX );
    settings.adaptive = RF_ADAPTIVE_OFF;
    settings.guide = RF_GUIDE_OFF;
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    settings.max_depth = look->settings->max_depth;
    settings.threads = 1; // pictures are too small to share out
    settings.memory = look->settings->memory;
    return settings;
}

// The light of a picture: of all, and of surfaces that move.
typedef struct Sums
{
    const Look* look;
    double all, moving;
} Sums;

static RfResult sum_picture( void* user, const RfFrameResult* result, RfError* error )
{
    Sums* sums = user;
    (void)error;
    for ( int i = 0; i < result->width * result->height; ++i )
    {
        const float* c = result->rgb + 3 * (size_t)i;
        double light = (double)rf_luminance( rf_vec3( c[0], c[1], c[2] ) );
        sums->all += light;
        sums->moving += sums->look->moving[i] ? light : 0.0;
    }
    return RF_OK;
}

static RfResult render_slot( const Look* look, const RfTracer* tracer, int run, int slot, Sums* sums, RfError* error )
{
    RfRelitTracer* relit;
    Lit lit = { look, slot };
    static const int only = 0;
    RfRenderSettings settings = pilot_settings( look );
    RfRenderCallbacks callbacks = { .user = sums, .frame = sum_picture };
    *sums = ( Sums ){ .look = look };
    RfResult result = rf_create_relit_tracer( tracer, is_in_slot, &lit, &relit, error );
    if ( result != RF_OK )
        return result;
    RfShot shot = { rf_relit_tracer( relit ), look->path->runs + run, 1, &only, 1 };
    result = rf_render( &shot, &settings, &callbacks, NULL, error );
    rf_destroy_relit_tracer( relit );
    return result;
}

// Which pixels show something that moves, in their middle.
static void find_moving( const Look* look, const RfTracer* tracer, const RfEye* eye )
{
    float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    for ( int y = 0; y < eye->height; ++y )
    {
        for ( int x = 0; x < eye->width; ++x )
        {
            RfVec3 o, d;
            float u, v;
            uint32_t triangle;
            rf_eye_ray( eye, inverse, x, y, 0.5f, 0.5f, &o, &d );
            rf_trace_nearest( tracer, 1, ( const float*[] ){ &o.x, &o.y, &o.z }, ( const float*[] ){ &d.x, &d.y, &d.z }, false,
                              &triangle, &u, &v );
            look->moving[y * eye->width + x] = rf_is_moving( tracer, triangle );
        }
    }
}

// Each of the frames of a run counts.
static RfResult look_at_light( Look* look, int run, int frames, RfError* error )
{
    RfSharing* sharing = look->sharing;
    const RfTracer* const* tracers = rf_open_worlds( &look->worlds, run, 1 );
    RfResult result = rf_check_worlds( &look->worlds, error );
    const RfTracer* tracer = tracers != NULL ? tracers[0] : look->tracer;
    int slots = number_slots( look );
    find_moving( look, tracer, look->path->runs + run );
    for ( int slot = -1; slot < slots && result == RF_OK; ++slot )
    {
        Sums sums;
        RfShared way = slot < MOST_ALONE ? RF_SHARED_AS_IT_IS : (RfShared)( slot - MOST_ALONE );
        result = render_slot( look, tracer, run, slot, &sums, error );
        for ( int i = 0; i < look->count && slot >= 0 && slot < MOST_ALONE; ++i )
        {
            if ( !look->changing[i].shines || look->slot[i] != slot )
                continue;
            sharing->of[i].share += frames * sums.all;
            way = look->way[i];
        }
        sharing->light[way] += frames * ( sums.all - sums.moving );
        sharing->moving += frames * sums.moving;
    }
    return result;
}

// Sums of light become shares of all, NaN where all is dark.
static void divide_light( const Look* look )
{
    RfSharing* sharing = look->sharing;
    double all = sharing->moving;
    for ( int k = 0; k < RF_SHARED_WAYS; ++k )
        all += sharing->light[k];
    for ( int k = 0; k < RF_SHARED_WAYS; ++k )
        sharing->light[k] /= all;
    sharing->moving /= all;
    for ( int i = 0, alone = 0; i < look->count; ++i )
    {
        bool known = look->changing[i].shines && alone++ < MOST_ALONE;
        sharing->of[i].share = known ? sharing->of[i].share / all : (double)NAN;
    }
}

static RfResult look_along( Look* look, const int* frames, RfError* error )
{
    RfSharing* sharing = look->sharing;
    int runs = look->path->run_count, looked = runs_to_look_at( look ), pilots = runs_to_light( look, looked );
    RfGroupPlan plan = rf_plan_shots( look->path->runs, runs, look->settings->group, 1 );
    Poses poses = { 0 };
    RfResult result = open_poses( look, &poses, error );
    for ( int k = 0, pilot = 0; k < looked && result == RF_OK; ++k )
    {
        int run = pick( k, looked, runs );
        if ( look->lights->changing != NULL )
            result = look_at_group( look, &plan, run, &poses, error );
        sharing->frames += frames[run];
        for ( int i = 0; i < look->count; ++i )
            sharing->of[i].frames[look->way[i]] += look->changing[i].shines ? frames[run] : 0;
        if ( result == RF_OK && pilot < pilots && k == pick( pilot, pilots, looked ) )
        {
            result = look_at_light( look, run, frames[run], error );
            ++pilot;
        }
    }
    close_poses( &poses );
    return result;
}

static RfResult look_at_path( Look* look, RfError* error )
{
    const RfCameraPath* path = look->path;
    size_t pixels = (size_t)path->runs->width * (size_t)path->runs->height, count = (size_t)look->count + 1;
    int* frames = calloc( (size_t)path->run_count, sizeof *frames );
    look->item = malloc( ( (size_t)look->lights->count + 1 ) * sizeof *look->item );
    look->slot = calloc( count, sizeof *look->slot );
    look->way = calloc( count, sizeof *look->way );
    look->moving = calloc( pixels, sizeof *look->moving );
    bool fits = frames != NULL && look->item != NULL && look->slot != NULL && look->way != NULL && look->moving != NULL;
    RfShot shot = { .tracer = look->tracer, .eyes = path->runs, .eye_count = path->run_count };
    int held = rf_worlds_held( look->scene, path->run_count, 1, false, false );
    RfResult result = fits ? rf_create_worlds( &shot, held, false, &look->worlds, error ) : fail_memory( error );
    if ( result == RF_OK )
    {
        for ( int i = 0; i < path->count; ++i )
            frames[path->run_of_frame[i]] += 1;
        result = number_items( look, error );
        if ( result == RF_OK )
            result = look_along( look, frames, error );
        divide_light( look );
        rf_destroy_worlds( &look->worlds );
    }
    free( frames );
    return result;
}

RfResult rf_find_sharing( const RfTracer* tracer, const RfCameraPath* path, const RfRenderSettings* settings,
                          const RfChanging* changing, int count, RfSharing* sharing, RfError* error )
{
    Look look = { .tracer = tracer,
                  .path = path,
                  .scene = rf_tracer_scene( tracer ),
                  .lights = rf_tracer_lights( tracer ),
                  .settings = settings,
                  .changing = changing,
                  .count = count,
                  .sharing = sharing };
    *sharing = ( RfSharing ){ .group = settings->group, .of = calloc( (size_t)count + 1, sizeof *sharing->of ) };
    RfResult result = sharing->of != NULL ? look_at_path( &look, error ) : fail_memory( error );
    free( look.item );
    free( look.slot );
    free( look.way );
    free( look.moving );
    if ( result != RF_OK )
        rf_destroy_sharing( sharing );
    return result;
}

void rf_destroy_sharing( RfSharing* sharing )
{
    free( sharing->of );
    *sharing = ( RfSharing ){ 0 };
}
