// The biased weightings of the literature, for comparison: `eq15` (Méndez Feliu) and `unweighted`.
#include "reuse/accumulate/biased_weights.h"

#include "base/fault.h"
#include "reuse/accumulate/reprojection.h"

#include <string.h>

// What arrives at the glossy hits from one direction (RfArrivalLanes): arrays of RF_LANES floats, a direction after the other.
typedef struct Arrivals
{
    float *a[3], *b[3], *light_pdf;
} Arrivals;

#define ARRAYS 7

size_t rf_arrivals_bytes( RfWeights weights, int directions )
{
    return weights == RF_WEIGHTS_EQ15 ? (size_t)directions * ARRAYS * RF_LANES * sizeof( float ) : 0;
}

static Arrivals arrivals_of( const RfHitBatch* batch, int direction )
{
    float* at = batch->arrivals + (size_t)direction * ARRAYS * RF_LANES;
    Arrivals lanes = { .light_pdf = at + 6 * RF_LANES };
    for ( int c = 0; c < 3; ++c )
    {
        lanes.a[c] = at + c * RF_LANES;
        lanes.b[c] = at + ( 3 + c ) * RF_LANES;
    }
    return lanes;
}

void rf_keep_arrivals( const RfHitBatch* batch, int direction, const RfArrivalLanes* arrival )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    size_t bytes = (size_t)rf_glossy_count( batch ) * sizeof( float );
    Arrivals lanes = arrivals_of( batch, direction );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( lanes.a[c], arrival->a[c] + first, bytes );
        memcpy( lanes.b[c], arrival->b[c] + first, bytes );
    }
    memcpy( lanes.light_pdf, arrival->light_pdf + first, bytes );
}

void rf_count_once( int count, float weight, float* ratio )
{
    for ( int i = 0; i < count; ++i )
        ratio[i] = ratio[i] > 0.0f ? weight : 0.0f;
}

void rf_note_landed_eyes( const RfAccumulation* a, const RfHitBatch* batch, const RfAccumulateScratch* s, int32_t low,
                          int32_t end, uint32_t* landed_eyes )
{
    size_t words = (size_t)rf_seen_words( a->shape.eyes );
    for ( int i = 0; i < batch->count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= low && pixel < end )
            landed_eyes[(size_t)pixel * words + (size_t)( batch->eye / 32 )] |= 1u << ( batch->eye % 32 );
    }
}

// Mean density over the cameras whose hits landed in the pixel.
static void mix_landed_eyes( const RfAccumulation* a, const RfHitBatch* batch, const uint32_t* landed_eyes, int direction,
                             RfAccumulateScratch* s, float* mixture )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    int words = rf_seen_words( a->shape.eyes );
    const RfDirectionLanes* lanes = batch->directions + direction;
    const float* wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] };
    float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    int32_t landed[RF_LANES] = { 0 };
    memset( mixture, 0, (size_t)count * sizeof *mixture );
    for ( int l = 0; l < a->shape.eyes; ++l )
    {
        RfEye at = rf_eye_of( a, l, batch );
        rf_directions_to( a->mirrors, &at, l, batch, wo );
        rf_evaluate_glossy( batch, wo_in, wi, NULL, s->pdf );
        for ( int i = 0; i < count; ++i )
        {
            uint32_t word = landed_eyes[(size_t)s->pixel[first + i] * (size_t)words + (size_t)( l / 32 )];
            int there = word >> ( l % 32 ) & 1u;
            mixture[i] += there ? s->pdf[i] : 0.0f;
            landed[i] += there;
        }
    }
    for ( int i = 0; i < count; ++i )
        mixture[i] /= (float)( landed[i] > 0 ? landed[i] : 1 );
}

// sum += f Q, where Q depends on the mixture density of the pixel.
static void add_direction( const Arrivals* lanes, int count, const float* mixture, RfAccumulateScratch* s )
{
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < count; ++i )
        {
            float p = mixture[i], both = lanes->light_pdf[i] + p;
            float of_lights = both > 0.0f || RF_FAULT( eq15_mixture ) ? lanes->a[c][i] / both : 0.0f;
            s->sum[c][i] += s->f[c][i] * ( of_lights + ( p > 0.0f || RF_FAULT( eq15_mixture ) ? lanes->b[c][i] / p : 0.0f ) );
        }
    }
}

void rf_light_glossy_eq15( const RfAccumulation* a, int eye, const RfHitBatch* batch, const uint32_t* landed_eyes,
                           RfAccumulateScratch* s )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    float *f[3] = { s->f[0], s->f[1], s->f[2] }, mixture[RF_LANES];
    RfEye at = rf_eye_of( a, eye, batch );
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            s->sum[c][i] = batch->radiance[4 * ( first + i ) + c];
    }
    for ( int d = 0; d < rf_direction_count( &a->shape ); ++d )
    {
        const RfDirectionLanes* lanes = batch->directions + d;
        const float* wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] };
        mix_landed_eyes( a, batch, landed_eyes, d, s, mixture );
        rf_directions_to( a->mirrors, &at, eye, batch, wo );
        rf_evaluate_glossy( batch, wo_in, wi, f, NULL );
        Arrivals kept = arrivals_of( batch, d );
        add_direction( &kept, count, mixture, s );
    }
}
