#include "gradient/components.h"

#include <string.h>

static size_t pixels( const RfGradientSystem* system ) { return (size_t)system->width * (size_t)system->height; }

bool rf_lacks_primal( const RfGradientSystem* system )
{
    for ( size_t i = 0; i < pixels( system ); ++i )
    {
        if ( !( system->a[i] > 0.0f ) )
            return true;
    }
    return false;
}

static uint32_t root_of( uint32_t* labels, uint32_t i )
{
    while ( labels[i] != i )
    {
        labels[i] = labels[labels[i]];
        i = labels[i];
    }
    return i;
}

static void join( uint32_t* labels, size_t i, size_t j )
{
    uint32_t a = root_of( labels, (uint32_t)i ), b = root_of( labels, (uint32_t)j );
    if ( a < b )
        labels[b] = a;
    else
        labels[a] = b;
}

void rf_label_components( const RfGradientSystem* system, uint32_t* labels )
{
    size_t w = (size_t)system->width, count = pixels( system );
    for ( size_t i = 0; i < count; ++i )
        labels[i] = (uint32_t)i;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( system->b_x[i] > 0.0f )
            join( labels, i, i + 1 );
        if ( system->b_y[i] > 0.0f )
            join( labels, i, i + w );
    }
    for ( size_t i = 0; i < count; ++i )
        labels[i] = root_of( labels, (uint32_t)i );
}

void rf_level_components( const RfGradientSystem* system, const uint32_t* labels, const float* start, float* u, double* sums )
{
    size_t count = pixels( system );
    double *offset = sums, *members = sums + count; // of the component with this first pixel; members < 0: it has a weight
    memset( sums, 0, 2 * count * sizeof *sums );
    for ( size_t i = 0; i < count; ++i )
    {
        size_t k = labels[i];
        offset[k] += (double)start[i] - (double)u[i];
        members[k] = system->a[i] > 0.0f || members[k] < 0.0 ? -1.0 : members[k] + 1.0;
    }
    for ( size_t i = 0; i < count; ++i )
    {
        size_t k = labels[i];
        if ( members[k] > 0.0 )
            u[i] += (float)( offset[k] / members[k] );
    }
}
