// Traces camera rays through the worst pixels of a frame and tells glints from light that was found by chance.
#include "render/specks.h"

#include "path/wavefront.h"
#include "scene/lens.h"
#include "scene/projection.h"
#include "scene/textured.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define LENS_SALT 0x1e4500000000u
#define RAYS 1024
#define RAYS_AT_ONCE 64 // of a thread, or those of one pixel
#define MOST_SPECULAR 8 // vertices before the first that is not
// The worst pixels have had bad luck: their errors are many times what is to be expected of their variance. Where direct light
// explains this part of one, it is a glint,
#define EXPLAINED ( 1.0 / 8.0 )
// and where it alone makes the pixel so many times as noisy as those that are no specks, or the specks of a material in the mean, a
// small part is enough. In rooms of chance it makes specks less noisy than others: they lie anywhere.
#define NOISIER 8.0
#define NOISIER_IN_THE_MEAN 3.0
#define LEAST_EXPLAINED ( 1.0 / 1024.0 )

#define SKY ( -1 )

typedef struct Work
{
    RfWavefront wavefront;
    RfRayLanes last;            // those that reach a surface that is not specular, or the sky
    float unlit[3][RF_LANES];   // by slot, of unlit surfaces that are seen
    int32_t material[RF_LANES]; // by slot, what is seen first; SKY
    bool specular[RF_LANES];    // likewise
} Work;

// What is known of a speck.
typedef struct Speck
{
    int seen;                // the material that most of the pixel has
    int material;            // or that of its brightest sample
    double share, explained; // parts of the frame's relMSE
    double noise;            // by direct light, times that of the pixels that are no specks
    RfSpeckKind kind;
} Speck;

// What rays are traced through. What moves is as in the middle of the shutter: rays share one wavefront, with cameras at moments of
// their own.
typedef struct Shape
{
    const RfRenderer* renderer;
    RfPathSettings path;
    int frame, pixels, samples; // samples of each pixel
} Shape;

static double samples_of( const RfRenderer* r, const RfLiveFilm* live )
{
    const RfFilm* film = live->films;
    double pixels = (double)r->setup->sizes.width * (double)r->setup->sizes.height;
    return film->passes[0] + film->passes[1] + (double)film->extra_samples / pixels;
}

static Shape make_shape( RfRenderer* r, const RfLiveFilm* live, int pixels )
{
    const RfRenderSettings* settings = &r->setup->settings;
    // in a group, lights may be others than those of the frame
    bool lights_change = rf_tracer_lights( r->setup->shot.tracer )->changing != NULL;
    const RfTracer* tracer = lights_change ? rf_frames_as_group( r, live->frame, 1, (int)RF_GROUP_OF_SPECKS ).tracer
                                           : rf_world_tracer( &r->worlds, live->frame );
    tracer = tracer != NULL ? tracer : r->setup->shot.tracer;
    bool lit = rf_tracer_lights( tracer )->count > 0 && settings->max_depth > 1;
    return ( Shape ){
        .renderer = r,
        .path = { .tracer = tracer,
                  .max_depth = lit ? 2 : 1, // direct light, no more
                  .light_samples = settings->light_samples,
                  .light_sampling = settings->light_sampling },
        .frame = live->frame,
        .pixels = pixels,
        .samples = RAYS / pixels,
    };
}

// A place in a pixel: the s-th of a sequence that is even (Roberts's R2), shifted.
static float place( const RfRenderSetup* setup, int pixel, int size, double step, int s, float shift )
{
    double u = (double)shift + s * step;
    float even = fminf( (float)( u - floor( u ) ), 0x1.fffffep-1f );
    return rf_is_plain_filter( &setup->settings ) ? even : rf_draw_filter_place( &setup->filter, pixel, size, even );
}

// Writes the camera ray of sample s of a pixel to a lane.
static void make_ray( const Shape* shape, int pixel, int s, int lane, RfWavefront* wavefront )
{
    const RfRenderSetup* setup = shape->renderer->setup;
    const RfEye* eye = setup->shot.eyes + shape->frame;
    uint64_t first = rf_pass_key( setup->settings.seed, (uint32_t)shape->frame, RF_GROUP_OF_SPECKS, 0 );
    uint64_t pass = rf_pass_key( setup->settings.seed, (uint32_t)shape->frame, RF_GROUP_OF_SPECKS, (uint32_t)s );
    RfRandomKey shift = rf_pixel_key( first, (uint32_t)pixel ), key = rf_pixel_key( pass, (uint32_t)pixel );
    RfRandomKey lens = rf_pixel_key( pass ^ LENS_SALT, (uint32_t)pixel );
    float u = rf_random( lens, 0 ), v = rf_random( lens, 1 ), time = rf_random( lens, 2 );
    RfEye sharp = rf_is_sharp( eye ) ? *eye : rf_sample_eye( eye, ( RfLensSample ){ u, v, time } );
    const float inverse[2] = { 1.0f / sharp.focal_x, 1.0f / sharp.focal };
    int column = pixel % eye->width, row = pixel / eye->width;
    float x = place( setup, column, eye->width, 0.7548776662466927, s, rf_random( shift, RF_DIMENSION_FILM_X ) );
    float y = place( setup, row, eye->height, 0.5698402909980532, s, rf_random( shift, RF_DIMENSION_FILM_Y ) );
    RfVec3 o, d;
    rf_eye_ray( &sharp, inverse, column, row, x, y, &o, &d );
    const float from[3] = { o.x, o.y, o.z }, to[3] = { d.x, d.y, d.z };
    for ( int c = 0; c < 3; ++c )
    {
        wavefront->rays.o[c][lane] = from[c];
        wavefront->rays.d[c][lane] = wavefront->rays.n[c][lane] = to[c];
        wavefront->rays.throughput[c][lane] = 1.0f;
    }
    wavefront->rays.pdf_solid_angle[lane] = RF_DELTA_PDF;
    wavefront->rays.slot[lane] = lane;
    wavefront->key_a[lane] = key.a;
    wavefront->key_b[lane] = key.b;
    wavefront->roulette_scale[lane] = 1.0f;
}

static void keep_ray( const RfRayLanes* from, int r, RfRayLanes* to )
{
    int at = to->count++;
    for ( int c = 0; c < 3; ++c )
    {
        to->o[c][at] = from->o[c][r];
        to->d[c][at] = from->d[c][r];
        to->n[c][at] = from->n[c][r];
        to->throughput[c][at] = from->throughput[c][r];
    }
    to->pdf_solid_angle[at] = from->pdf_solid_angle[r];
    to->slot[at] = from->slot[r];
}

static void note_unlit( const RfPathSettings* settings, const RfRayLanes* rays, Work* work )
{
    const RfMaterial* materials = rf_tracer_scene( settings->tracer )->materials;
    const RfVertexLanes* v = &work->wavefront.vertices;
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        for ( int c = 0; c < 3 && materials[v->material[i]].unlit; ++c )
            work->unlit[c][v->slot[i]] = v->emission[c][i] * rays->throughput[c][v->ray[i]];
    }
}

static void note_first( Work* work )
{
    const RfVertexLanes* v = &work->wavefront.vertices;
    for ( int i = 0; i < v->count; ++i )
    {
        work->material[v->slot[i]] = v->material[i];
        work->specular[v->slot[i]] = i >= rf_record_count( v );
    }
}

// Follows the rays through a specular vertex. The others are kept as they are.
static void pass_specular( const RfPathSettings* settings, int vertex, RfRayLanes* rays, RfRayLanes* next, Work* work )
{
    RfWavefront* wavefront = &work->wavefront;
    const RfVertexLanes* v = &wavefront->vertices;
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    bool ends[RF_LANES];
    for ( int r = 0; r < rays->count; ++r )
        ends[r] = true;
    rf_absorb( v, rays );
    note_unlit( settings, rays, work );
    rf_scatter_lanes( wavefront, v, RF_DIMENSION_CHAINS + rf_vertex_dimension( vertex, settings->light_samples ), wi, s );
    next->count = 0;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        const float to[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, to );
        int r = v->ray[i];
        ends[r] = false;
        for ( int c = 0; c < 3; ++c )
            next->throughput[c][next->count] = rays->throughput[c][r] * s->f[c][i];
        rf_write_ray( v, i, to, side, s->pdf[i], next, next->count );
        next->count += side != 0.0f;
    }
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( ends[r] )
            keep_ray( rays, r, &work->last );
    }
}

// Emission and direct light at the first surface that is not specular: in the wavefront's arrivals, by slot.
static void trace( const Shape* shape, Work* work )
{
    RfWavefront* wavefront = &work->wavefront;
    RfRayLanes *rays = &wavefront->rays, *next = &wavefront->next;
    int count = rays->count;
    work->last.count = 0;
    memset( work->unlit, 0, sizeof work->unlit );
    for ( int i = 0; i < count; ++i )
    {
        work->material[i] = SKY;
        work->specular[i] = false;
    }
    for ( int vertex = 1; vertex <= MOST_SPECULAR && rays->count > 0; ++vertex )
    {
        rf_find_vertices( &shape->path, rays, vertex == 1, &wavefront->vertices, &wavefront->scratch );
        if ( vertex == 1 )
            note_first( work );
        pass_specular( &shape->path, vertex, rays, next, work );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
    wavefront->rays = work->last;
    rf_clear_ray_counts( wavefront );
    rf_clear_arrivals( count, &wavefront->arrivals );
    rf_trace_tails( &shape->path, wavefront, 1 );
}

static double light_of( const Work* work, int c, int slot )
{
    const RfArrivals* a = &work->wavefront.arrivals;
    return (double)a->emitted[c][slot] + (double)a->rest[c][slot] + (double)work->unlit[c][slot];
}

static double variance_of( const Work* work, int first, int count )
{
    double variance = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        double sum = 0.0, squares = 0.0;
        for ( int s = first; s < first + count; ++s )
            sum += light_of( work, c, s ) / count;
        for ( int s = first; s < first + count; ++s )
            squares += ( light_of( work, c, s ) - sum ) * ( light_of( work, c, s ) - sum );
        variance += squares / ( count - 1 );
    }
    return variance;
}

static int brightest_of( const Work* work, int first, int count )
{
    double most = -1.0;
    int brightest = first;
    for ( int s = first; s < first + count; ++s )
    {
        double light = light_of( work, 0, s ) + light_of( work, 1, s ) + light_of( work, 2, s );
        brightest = light > most ? s : brightest;
        most = fmax( most, light );
    }
    return brightest;
}

static int usual_material( const Work* work, int first, int count )
{
    int most = 0, usual = SKY;
    for ( int s = first; s < first + count; ++s )
    {
        int same = 0;
        for ( int k = first; k < first + count; ++k )
            same += work->material[k] == work->material[s];
        usual = same > most ? work->material[s] : usual;
        most = same > most ? same : most;
    }
    return usual;
}

// By its slots from `first` on. A sample lands in about as many pixels as frames share it, unless what is seen first is specular.
static Speck examine( const Shape* shape, const RfLiveFilm* live, const Work* work, const RfSpeckList* list, int k, int first )
{
    int specular = 0;
    double pixels = (double)shape->renderer->setup->sizes.width * (double)shape->renderer->setup->sizes.height;
    double native = samples_of( shape->renderer, live ), landed = (double)live->films[0].landed / pixels;
    for ( int s = first; s < first + shape->samples; ++s )
        specular += work->specular[s];
    double in_pixel = 2 * specular > shape->samples ? native : fmax( landed, native );
    double part = variance_of( work, first, shape->samples ) / in_pixel / list->worst[k].variance;
    double explained = list->worst[k].share * ( isfinite( part ) ? fmin( part, 1.0 ) : 0.0 );
    double noise = explained * pixels / fmax( 1.0 - list->share, 1e-12 );
    int seen = usual_material( work, first, shape->samples );
    bool glint = isgreaterequal( part, noise >= NOISIER ? LEAST_EXPLAINED : EXPLAINED );
    return ( Speck ){
        .seen = seen,
        .material = glint ? work->material[brightest_of( work, first, shape->samples )] : seen,
        .share = list->worst[k].share,
        .explained = explained,
        .noise = noise,
        .kind = glint ? RF_SPECK_GLINT : RF_SPECK_OTHER,
    };
}

// Traces the rays of pixels [first, first + count) of the list.
static void examine_some( const Shape* shape, const RfLiveFilm* live, const RfSpeckList* list, int first, int count, Work* work,
                          Speck* found )
{
    work->wavefront.rays.count = count * shape->samples;
    for ( int lane = 0; lane < work->wavefront.rays.count; ++lane )
        make_ray( shape, list->worst[first + lane / shape->samples].pixel, lane % shape->samples, lane, &work->wavefront );
    trace( shape, work );
    for ( int k = first; k < first + count; ++k )
        found[k] = examine( shape, live, work, list, k, ( k - first ) * shape->samples );
}

// Has the scene surfaces that send on the light of a small lamp bundled?
static bool has_gloss( const RfScene* scene )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        const RfMaterial* m = scene->materials + i;
        if ( rf_roughness_varies( m ) || !rf_is_matte( m->kind, m->alpha ) )
            return true;
    }
    return false;
}

// What is no glint yet.
static void decide( Speck* specks, int count, bool chance )
{
    for ( int k = 0; k < count; ++k )
    {
        double share = 0.0, explained = 0.0, noise = 0.0, all = 0.0;
        for ( int i = 0; i < count; ++i )
        {
            bool same = specks[i].seen == specks[k].seen;
            share += same ? specks[i].share : 0.0;
            explained += same ? specks[i].explained : 0.0;
            noise += same ? specks[i].noise : 0.0;
            all += same ? 1.0 : 0.0;
        }
        if ( noise >= NOISIER_IN_THE_MEAN * all && explained >= LEAST_EXPLAINED * share )
            specks[k].kind = RF_SPECK_GLINT;
        else if ( specks[k].kind != RF_SPECK_GLINT && chance )
            specks[k].kind = RF_SPECK_CHANCE;
    }
}

// Adds a speck that stands for `pixels` and `share` of the error, keeping the order.
static void add_part( RfSpecks* specks, const Speck* speck, double share )
{
    int at = 0;
    while ( at < specks->part_count &&
            ( specks->parts[at].material != speck->material || specks->parts[at].kind != speck->kind ) )
        ++at;
    if ( at == specks->part_count )
        specks->parts[specks->part_count++] = ( RfSpeckPart ){ .kind = speck->kind, .material = speck->material };
    RfSpeckPart part = specks->parts[at];
    part.pixels += 1;
    part.share += share;
    for ( ; at > 0 && specks->parts[at - 1].share < part.share; --at )
        specks->parts[at] = specks->parts[at - 1];
    specks->parts[at] = part;
}

// What was examined stands for all.
static void sum_up( const Speck* found, int count, RfSpecks* specks )
{
    double share = 0.0;
    for ( int k = 0; k < count; ++k )
        share += found[k].share;
    for ( int k = 0; k < count; ++k )
        add_part( specks, found + k, share > 0.0 ? found[k].share / share * specks->share : 0.0 );
    for ( int p = 0; p < specks->part_count; ++p )
        specks->parts[p].pixels = (int)( ( (int64_t)specks->parts[p].pixels * specks->pixels + count / 2 ) / count );
}

// The group that the workspaces were laid out for: of its sizes alone.
static RfEstimatorGroup sizes_group( const RfRenderer* r )
{
    const RfRenderSetup* setup = r->setup;
    return ( RfEstimatorGroup ){ .tracer = setup->shot.tracer,
                                 .settings = &setup->settings,
                                 .traits = setup->traits,
                                 .width = setup->sizes.width,
                                 .height = setup->sizes.height,
                                 .max_depth = setup->settings.max_depth,
                                 .eyes = setup->shot.eyes,
                                 .eye_count = setup->plan.eyes,
                                 .compiled = rf_compiled( r, setup->plan.eyes ) };
}

void rf_find_specks( RfRenderer* r, const RfLiveFilm* live, const RfSpeckList* list, RfSpecks* specks )
{
    const RfRenderSetup* setup = r->setup;
    *specks = ( RfSpecks ){ .pixels = list->pixels, .share = list->share, .rest = list->rest };
    if ( list->count == 0 || setup->sizes.of_estimator.trace_scratch < sizeof( Work ) )
        return;
    Shape shape = make_shape( r, live, list->count );
    RfEstimatorGroup group = sizes_group( r );
    Speck found[RF_LISTED_SPECKS];
    int at_once = shape.samples < RAYS_AT_ONCE ? RAYS_AT_ONCE / shape.samples : 1; // pixels
#pragma omp parallel num_threads( setup->settings.threads )
    {
        rf_set_float_mode();
        Work* work = r->memory.trace_scratch[omp_get_thread_num()];
        bool used = false;
#pragma omp for schedule( dynamic, 1 )
        for ( int first = 0; first < shape.pixels; first += at_once )
        {
            int left = shape.pixels - first;
            if ( !used )
                memset( work, 0, sizeof *work );
            used = true;
            examine_some( &shape, live, list, first, left < at_once ? left : at_once, work, found );
        }
        if ( used )
            setup->settings.estimator->lay_out_scratch( &group, work );
    }
    decide( found, shape.pixels, has_gloss( rf_tracer_scene( setup->shot.tracer ) ) );
    sum_up( found, shape.pixels, specks );
}

const char* rf_speck_kind_name( RfSpeckKind kind )
{
    static const char* const names[RF_SPECK_KINDS] = { "glint", "chance", "other" };
    return names[kind];
}
