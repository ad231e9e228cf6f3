#include "differential/differential.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

// Inputs are moved by so many of their roundings: the jump of a horizon is near even if not one of them leads across.
#define STRIDE 4.0

// Nothing is judged where roundings of the inputs alone change more than this part of the output.
#define UNDETERMINED 0.05

void find_spread( const Check* check, const double* x, const double* step, const double* y, double* spread )
{
    double moved[MAX_INPUTS], out[MAX_OUTPUTS];
    memcpy( moved, x, (size_t)check->inputs * sizeof *x );
    for ( int o = 0; o < check->outputs; ++o )
        spread[o] = 0.0;
    for ( int i = 0; i < check->inputs; ++i )
    {
        double most[MAX_OUTPUTS] = { 0 };
        for ( int side = -1; side <= 1 && step[i] > 0.0; side += 2 )
        {
            moved[i] = x[i] + side * STRIDE * step[i];
            check->reference( moved, out );
            for ( int o = 0; o < check->outputs; ++o )
            {
                double change = fabs( out[o] - y[o] );
                most[o] = change > most[o] || isnan( change ) ? change : most[o];
            }
        }
        moved[i] = x[i];
        for ( int o = 0; o < check->outputs; ++o )
            spread[o] += most[o] / STRIDE;
    }
}

static void note( Worst* worst, double error, double condition, double got, double want, const Check* check, const double* x )
{
    if ( error <= worst->error && worst->where[0] != 0 )
        return;
    *worst = ( Worst ){ error, condition, got, want, { 0 } };
    check->describe( x, worst->where, sizeof worst->where );
}

// Whether a case may be worse than the worst so far, whatever its condition: the others need no spread.
static bool may_be_worst( const Check* check, const double* y, const double* got )
{
    bool any = false;
    for ( int o = 0; o < check->outputs; ++o )
    {
        const Row* row = check->row + o;
        double relative = fabs( got[o] - y[o] ) / ( fabs( y[o] ) + row->scale + NOTHING );
        any |= !( relative <= UNIT_ROUNDOFF * row->roundings.error && relative <= row->relative.error );
    }
    return any;
}

void judge( Check* check, const double* x, const double* step, const double* got )
{
    double y[MAX_OUTPUTS], spread[MAX_OUTPUTS];
    check->reference( x, y );
    for ( int o = 0; o < check->outputs; ++o )
        check->row[o].count += !isnan( y[o] );
    if ( !may_be_worst( check, y, got ) )
        return;
    find_spread( check, x, step, y, spread );
    for ( int o = 0; o < check->outputs; ++o )
    {
        Row* row = check->row + o;
        // NaN of the reference: not defined here, or next to where it is not
        if ( isnan( y[o] ) || isnan( spread[o] ) )
            continue;
        double size = fabs( y[o] ) + row->scale + NOTHING, error = isfinite( got[o] ) ? fabs( got[o] - y[o] ) : INFINITY;
        double condition = spread[o] / ( UNIT_ROUNDOFF * size );
        if ( spread[o] > UNDETERMINED * size && isfinite( got[o] ) )
            continue;
        note( &row->roundings, error / ( UNIT_ROUNDOFF * size + spread[o] ), condition, got[o], y[o], check, x );
        if ( condition <= 100.0 )
            note( &row->relative, error / size, condition, got[o], y[o], check, x );
    }
}

void print_head( void )
{
    printf( "| function | inputs | worst error, roundings | allowed | its condition | where | worst relative error, condition ≤ "
            "100 | "
            "where |\n|---|---|---|---|---|---|---|---|\n" );
}

int print_check( const Check* check )
{
    int bad = 0;
    for ( int o = 0; o < check->outputs; ++o )
    {
        const Row* row = check->row + o;
        printf( "| %s | %.2g | %.1f | %g | %.0e | %s | %.1e | %s |\n", row->name, (double)row->count, row->roundings.error,
                row->limit, row->roundings.condition, row->roundings.where, row->relative.error, row->relative.where );
        if ( row->count > 0 && row->roundings.error <= row->limit && row->relative.error <= 1e-3 )
            continue;
        ++bad;
        fprintf( stderr, "%s: %s: %.9g instead of %.9g at %s; well conditioned: %.9g instead of %.9g at %s\n", row->name,
                 row->count == 0 ? "nothing was judged" : "too large an error", row->roundings.got, row->roundings.want,
                 row->roundings.where, row->relative.got, row->relative.want, row->relative.where );
    }
    return bad;
}

// ---- Inputs -------------------------------------------------------------------

double random_number( uint32_t stream, long i, uint32_t dimension )
{
    return (double)rf_random( rf_pixel_key( rf_pass_key( 20, stream, 0, 0 ), (uint32_t)i ), dimension );
}

double random_between( double low, double high, uint32_t stream, long i, uint32_t dimension )
{
    double u = random_number( stream, i, dimension ), end = random_number( stream, i, dimension + 1000 );
    return end < 0.125 ? low : end > 0.875 ? high : low + ( high - low ) * u;
}

double random_wide( double low, double high, uint32_t stream, long i, uint32_t dimension )
{
    return exp( random_between( log( low ), log( high ), stream, i, dimension ) );
}

RfVec3 random_direction( uint32_t stream, long i, uint32_t dimension )
{
    double z = 2.0 * random_number( stream, i, dimension ) - 1.0, r = sqrt( fmax( 1.0 - z * z, 0.0 ) );
    double phi = 6.283185307179586 * random_number( stream, i, dimension + 1 );
    int corner = (int)( 64.0 * random_number( stream, i, dimension + 2000 ) );
    if ( corner < 6 ) // along an axis
        return rf_vec3( (float)( corner == 0 ) - (float)( corner == 1 ), (float)( corner == 2 ) - (float)( corner == 3 ),
                        (float)( corner == 4 ) - (float)( corner == 5 ) );
    return rf_vec3( (float)( r * cos( phi ) ), (float)( r * sin( phi ) ), (float)z );
}

RfVec3 random_around( RfVec3 axis, uint32_t stream, long i, uint32_t dimension )
{
    RfVec3 t, b;
    rf_basis( axis, &t, &b );
    double angle = random_wide( 1e-7, 1.57, stream, i, dimension ),
           phi = 6.283185307179586 * random_number( stream, i, dimension + 1 );
    double kind = random_number( stream, i, dimension + 2 );
    if ( kind < 0.3 ) // grazing, above the horizon or a little below
        angle = 1.5707963267948966 - ( kind < 0.06 ? -angle : angle );
    else if ( kind < 0.6 )
        angle = acos( 1.0 - random_number( stream, i, dimension + 3 ) );
    double s = sin( angle ), c = cos( angle ), x = s * cos( phi ), y = s * sin( phi );
    return rf_vec3( (float)( x * t.x + y * b.x + c * axis.x ), (float)( x * t.y + y * b.y + c * axis.y ),
                    (float)( x * t.z + y * b.z + c * axis.z ) );
}

static void add( Inputs* in, double value, double step )
{
    in->x[in->count] = value;
    in->step[in->count++] = step;
}

void add_direction( Inputs* in, RfVec3 d )
{
    add( in, (double)d.x, UNIT_ROUNDOFF );
    add( in, (double)d.y, UNIT_ROUNDOFF );
    add( in, (double)d.z, UNIT_ROUNDOFF );
}

void add_point( Inputs* in, RfVec3 p, float largest )
{
    double step = UNIT_ROUNDOFF * (double)largest;
    add( in, (double)p.x, step );
    add( in, (double)p.y, step );
    add( in, (double)p.z, step );
}

void add_number( Inputs* in, double value ) { add( in, value, UNIT_ROUNDOFF * fabs( value ) ); }

void add_rounding( Inputs* in ) { add( in, 0.0, UNIT_ROUNDOFF ); }
