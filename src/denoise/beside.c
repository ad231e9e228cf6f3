// Follows the pixels of a frame into the frames before and after.
//
// Whether both see the same surface is told by albedo and normal, in which the noise of the light has no part: so the mean of first
// halves knows nothing of the second ones.
#include "denoise/beside.h"

#include "trace/trace.h"

#include <math.h>

#define ALIKE 0.02 // squared difference of albedo and normal at which a pixel counts half

bool rf_has_frames_beside( const RfNoisyFrame* frame )
{
    bool known = frame->motion != NULL && frame->albedo != NULL && frame->normal != NULL;
    return known && ( frame->beside[0].halves != NULL || frame->beside[1].halves != NULL );
}

// The four pixels around a place, and their weights.
typedef struct Place
{
    size_t pixel[4];
    float weight[4];
} Place;

// False beyond the picture, and where the motion is not known.
static bool find_place( const RfNoisyFrame* frame, float x, float y, Place* place )
{
    float most_x = (float)( frame->width - 1 ), most_y = (float)( frame->height - 1 );
    if ( !( x > -0.5f && x < most_x + 0.5f && y > -0.5f && y < most_y + 0.5f ) )
        return false;
    x = fminf( fmaxf( x, 0.0f ), most_x );
    y = fminf( fmaxf( y, 0.0f ), most_y );
    int column = (int)x, row = (int)y;
    float u = x - (float)column, v = y - (float)row;
    for ( int k = 0; k < 4; ++k )
    {
        int i = column + ( k & 1 ), j = row + ( k >> 1 );
        i = i < frame->width ? i : frame->width - 1;
        j = j < frame->height ? j : frame->height - 1;
        place->pixel[k] = (size_t)j * (size_t)frame->width + (size_t)i;
        place->weight[k] = ( ( k & 1 ) != 0 ? u : 1.0f - u ) * ( ( k >> 1 ) != 0 ? v : 1.0f - v );
    }
    return true;
}

static float value_at( const Place* place, const float* image, size_t c )
{
    float sum = 0.0f;
    for ( int k = 0; k < 4; ++k )
        sum += place->weight[k] * image[3 * place->pixel[k] + c];
    return sum;
}

// How much a place of another frame counts for pixel i, 0 to 1.
static float likeness( const RfNoisyFrame* frame, const RfFrameBeside* beside, const Place* place, size_t i )
{
    float apart = 0.0f;
    for ( size_t c = 0; c < 3; ++c )
    {
        float albedo = value_at( place, beside->albedo, c ) - frame->albedo[3 * i + c];
        float normal = value_at( place, beside->normal, c ) - frame->normal[3 * i + c];
        apart += albedo * albedo + normal * normal;
    }
    return isfinite( apart ) ? 1.0f / ( 1.0f + apart * apart / (float)( ALIKE * ALIKE ) ) : 0.0f;
}

// The motion is in pixels, upwards: first to the frame before, then to the one after.
static void follow_pixel( const RfNoisyFrame* frame, float* const own[2], float* along[2], int x, int y )
{
    size_t i = (size_t)y * (size_t)frame->width + (size_t)x;
    float sum[2][3], weights = 1.0f;
    for ( int h = 0; h < 2; ++h )
    {
        for ( size_t c = 0; c < 3; ++c )
            sum[h][c] = own[h][3 * i + c];
    }
    for ( int side = 0; side < 2; ++side )
    {
        const RfFrameBeside* beside = frame->beside + side;
        const float* motion = frame->motion + 4 * i + 2 * side;
        Place place;
        if ( beside->halves == NULL || !find_place( frame, (float)x + motion[0], (float)y - motion[1], &place ) )
            continue;
        float weight = likeness( frame, beside, &place, i );
        weights += weight;
        for ( int h = 0; h < 2; ++h )
        {
            for ( size_t c = 0; c < 3; ++c )
                sum[h][c] += weight * value_at( &place, beside->halves->half[h], c );
        }
    }
    for ( int h = 0; h < 2; ++h )
    {
        for ( size_t c = 0; c < 3; ++c )
            along[h][3 * i + c] = sum[h][c] / weights;
    }
}

void rf_mean_along_motion( const RfNoisyFrame* frame, float* const own[2], float* along[2] )
{
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < frame->height; ++y )
    {
        rf_set_float_mode();
        for ( int x = 0; x < frame->width; ++x )
            follow_pixel( frame, own, along, x, y );
    }
}
