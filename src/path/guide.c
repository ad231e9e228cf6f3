// Path guiding: samples tables, and mixes their densities with those of BSDFs.
#include "path/guide.h"

#include <stdlib.h>

#define LAST 0x1.fffffep-1f // below 1

void rf_find_guide_tables( const RfGuide* guide, int count, const float* const p[3], const float* const n[3], int32_t* table )
{
    const RfGuideNode* nodes = guide->nodes;
    const float *x = p[0], *y = p[1], *z = p[2];
    for ( int i = 0; i < count; ++i )
        table[i] = rf_guide_axis( RF_GET3( n, i ) );
    for ( int step = 0; step < guide->depth; ++step )
    {
#pragma omp simd
        for ( int i = 0; i < count; ++i )
        {
            RfGuideNode node = nodes[table[i]];
            float at = node.axis == 0 ? x[i] : node.axis == 1 ? y[i] : z[i];
            table[i] = node.child + ( at >= node.split );
        }
    }
    for ( int i = 0; i < count; ++i )
        table[i] = nodes[table[i]].table;
}

// The interval of cumulative probabilities that u is in; `rest` is where in it.
static int choose( const float* cumulative, float u, float* rest )
{
    int at = 0;
    for ( int step = RF_GUIDE_SIDE / 2; step > 0; step /= 2 )
        at += u >= cumulative[at + step - 1] ? step : 0;
    float below = at > 0 ? cumulative[at - 1] : 0.0f, here = cumulative[at] - below;
    *rest = here > 0.0f ? rf_clampf( ( u - below ) / here, 0.0f, LAST ) : 0.5f;
    return at;
}

RfVec3 rf_sample_guide( const RfGuideTable* table, float u, float v )
{
    float in_row, in_bin;
    int row = choose( table->row, u, &in_row ), column = choose( table->column + RF_GUIDE_SIDE * row, v, &in_bin );
    const float step = 2.0f / RF_GUIDE_SIDE;
    float x = ( (float)column + in_bin ) * step - 1.0f, y = ( (float)row + in_row ) * step - 1.0f;
    float z = 1.0f - fabsf( x ) - fabsf( y );
    float folded_x = copysignf( 1.0f - fabsf( y ), x ), folded_y = copysignf( 1.0f - fabsf( x ), y );
    return rf_normalize( z < 0.0f ? rf_vec3( folded_x, folded_y, z ) : rf_vec3( x, y, z ) );
}

void rf_mix_guide( const RfGuide* guide, int count, const int32_t* table, const float* const wi[3],
                   float* restrict pdf_solid_angle )
{
    if ( count == 0 ) // of no lanes the guide may not be set
        return;
    const RfGuideTable* tables = guide->tables;
    const float *x = wi[0], *y = wi[1], *z = wi[2];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        const RfGuideTable* t = tables + ( table[i] < 0 ? 0 : table[i] );
        float share = table[i] < 0 ? 0.0f : t->share;
        float guided = rf_guide_pdf_solid_angle( t, rf_vec3( x[i], y[i], z[i] ) );
        pdf_solid_angle[i] += share * ( guided - pdf_solid_angle[i] );
    }
}

void rf_finish_guide_table( RfGuideTable* table )
{
    double sum = 0.0, rows = 0.0;
    for ( int k = 0; k < RF_GUIDE_BINS; ++k )
        sum += (double)table->density[k];
    for ( int row = 0; row < RF_GUIDE_SIDE; ++row )
    {
        float *density = table->density + RF_GUIDE_SIDE * row, *column = table->column + RF_GUIDE_SIDE * row;
        double here = 0.0, below = 0.0;
        for ( int k = 0; k < RF_GUIDE_SIDE; ++k )
            here += (double)density[k];
        for ( int k = 0; k < RF_GUIDE_SIDE; ++k )
        {
            below += (double)density[k];
            column[k] = here > 0.0 ? (float)( below / here ) : 1.0f;
            density[k] = (float)( 0.25 * RF_GUIDE_BINS / sum * (double)density[k] );
        }
        rows += here;
        table->row[row] = (float)( rows / sum );
    }
}

void rf_destroy_guide( RfGuide* guide )
{
    if ( guide == NULL )
        return;
    free( guide->nodes );
    free( guide->tables );
    free( guide );
}
