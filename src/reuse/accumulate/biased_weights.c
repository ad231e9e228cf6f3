// The biased weightings of the literature, for comparison: `eq15` (Méndez Feliu) and `unweighted`.
#include "reuse/accumulate/biased_weights.h"

#include "base/fault.h"
#include "reuse/accumulate/reprojection.h"

#include <string.h>

#define ARRAYS 7 // of a direction

static size_t struct_bytes( int directions ) { return ( (size_t)directions * sizeof( RfEq15Lanes ) + 63 ) / 64 * 64; }

size_t rf_eq15_bytes( int directions )
{
    return struct_bytes( directions ) + (size_t)directions * ARRAYS * RF_LANES * sizeof( float );
}

RfEq15Lanes* rf_lay_out_eq15( int directions, void* memory )
{
    RfEq15Lanes* lanes = memory;
    float* at = (float*)(void*)( (char*)memory + struct_bytes( directions ) );
    for ( int d = 0; d < directions; ++d, at += ARRAYS * RF_LANES )
    {
        for ( int c = 0; c < 3; ++c )
        {
            lanes[d].a[c] = at + c * RF_LANES;
            lanes[d].b[c] = at + ( 3 + c ) * RF_LANES;
        }
        lanes[d].light_pdf = at + 6 * RF_LANES;
    }
    return lanes;
}

void rf_keep_eq15( const RfHitBatch* batch, const RfArrivalLanes* arrival, RfEq15Lanes* direction )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    size_t bytes = (size_t)rf_glossy_count( batch ) * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( direction->a[c], arrival->a[c] + first, bytes );
        memcpy( direction->b[c], arrival->b[c] + first, bytes );
    }
    memcpy( direction->light_pdf, arrival->light_pdf + first, bytes );
}

void rf_clear_eq15( const RfHitBatch* batch, int directions )
{
    size_t bytes = (size_t)rf_glossy_count( batch ) * sizeof( float );
    for ( int d = 0; d < directions; ++d )
    {
        for ( int c = 0; c < 3; ++c )
        {
            memset( batch->eq15[d].a[c], 0, bytes );
            memset( batch->eq15[d].b[c], 0, bytes );
        }
        memset( batch->eq15[d].light_pdf, 0, bytes );
    }
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
static void add_direction( const RfEq15Lanes* lanes, int count, const float* mixture, RfAccumulateScratch* s )
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
        add_direction( batch->eq15 + d, count, mixture, s );
    }
}
