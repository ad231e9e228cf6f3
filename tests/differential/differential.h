// What float code computes against references in double precision, and how the difference is judged (README.md).
#ifndef REFRAME_TESTS_DIFFERENTIAL_H
#define REFRAME_TESTS_DIFFERENTIAL_H

#include "base/float_traps.h"
#include "base/random.h"
#include "math/vec3.h"

#include "support/owned.h"

#include <stddef.h>

#define UNIT_ROUNDOFF 0x1p-24 // a float is known to this relative error
#define NOTHING 1e-15         // what is smaller counts as 0: a lobe's tail
#define MAX_INPUTS 48
#define MAX_OUTPUTS 6

// y = the outputs at the inputs x, in double precision.
typedef void Reference( const double* x, double* y );

// Writes what tells a case from others, for people.
typedef void Describe( const double* x, char* text, size_t size );

// The worst case so far, by one of the two measures.
typedef struct Worst
{
    double error, condition, got, want;
    char where[160];
} Worst;

// One output of a function: a row of the table.
typedef struct Row
{
    const char* name;
    double scale; // the unit of absolute errors: 0 for quantities whose relative error counts
    double limit; // of the error in roundings
    long count;
    Worst relative; // of the cases with a condition of at most 100
    Worst roundings;
} Row;

typedef struct Check
{
    int inputs, outputs;
    Reference* reference;
    Describe* describe;
    Row row[MAX_OUTPUTS];
} Check;

// What roundings of the inputs alone do to the outputs y: the sum over the inputs of the largest change.
void find_spread( const Check* check, const double* x, const double* step, const double* y, double* spread );

// Judges what the code got at the inputs x, each known to ± step. Nothing is judged where the reference is NaN.
void judge( Check* check, const double* x, const double* step, const double* got );

// Prints a row for each output; returns the number of rows over their limits.
int print_check( const Check* check );
void print_head( void );

// ---- Inputs -------------------------------------------------------------------

// The call under test, with traps in builds that have them.
#define TRAPPED( call )                                                                                                          \
    do                                                                                                                           \
    {                                                                                                                            \
        rf_enable_float_traps();                                                                                                 \
        call;                                                                                                                    \
        rf_pause_float_traps();                                                                                                  \
    } while ( 0 )

// Uniform in [0, 1).
double random_number( uint32_t stream, long i, uint32_t dimension );
// Log-uniform; `low` and `high` themselves in an eighth of the cases each.
double random_wide( double low, double high, uint32_t stream, long i, uint32_t dimension );
// Uniform; `low` and `high` themselves in an eighth of the cases each.
double random_between( double low, double high, uint32_t stream, long i, uint32_t dimension );
RfVec3 random_direction( uint32_t stream, long i, uint32_t dimension );
// At a log-uniform angle, from 1e-7 rad up, to a random direction near `axis`, or to its horizon: any, near the axis, or grazing.
RfVec3 random_around( RfVec3 axis, uint32_t stream, long i, uint32_t dimension );

// Appends inputs: directions (known to a rounding of 1), points and numbers.
typedef struct Inputs
{
    int count;
    double x[MAX_INPUTS], step[MAX_INPUTS];
} Inputs;

void add_direction( Inputs* in, RfVec3 d );
void add_point( Inputs* in, RfVec3 p, float largest ); // coordinates known to a rounding of `largest`
void add_number( Inputs* in, double value );
void add_rounding( Inputs* in ); // 0, known to a rounding of 1

// ---- The checks ---------------------------------------------------------------

// Each takes about `count` inputs per function, prints its rows and returns how many are over their limits.
int check_cameras( long count );
int check_models( long count );
int check_sampling( long count );
int check_glass( long count );
int check_lights( long count );
int check_tiles( long count );

#endif
