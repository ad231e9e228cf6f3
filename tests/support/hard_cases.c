#include "support/hard_cases.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

RfRenderSettings small_settings( int group, int spp )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 5;
    settings.threads = 1; // small pictures: more would wait for each other
    settings.memory = (size_t)256 << 20;
    return settings;
}

// What (E2) subtracts is bounded by what the pixel holds in all.
static bool may_be_negative( const RfRenderSettings* settings )
{
    return settings->group != 0 && settings->weights == RF_WEIGHTS_EXACT && settings->normalize == RF_NORMALIZE_CROSSFIT;
}

static void fail_pixel( const char* what, const RfRenderSettings* s, size_t i, double value )
{
    print_error( "%s: group %d, weights %d, normalize %d: value %zu is %g\n", what, s->group, (int)s->weights, (int)s->normalize,
                 i, value );
    fail();
}

double check_sane_settings( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count,
                            const RfRenderSettings* settings )
{
    Rendered r = render_all( tracer, eyes, eye_count, settings );
    assert_int_equal( r.count, eye_count );
    double sum = 0.0;
    size_t values = 3 * r.pixels * (size_t)r.count;
    for ( size_t i = 0; i < values; ++i )
    {
        double value = (double)r.rgb[i];
        if ( !isfinite( value ) || ( value < 0.0 && !may_be_negative( settings ) ) )
            fail_pixel( what, settings, i, value );
        sum += value / (double)values;
    }
    for ( size_t i = 0; i < r.pixels * (size_t)r.count; ++i )
    {
        double weight = (double)r.weight[i];
        if ( !isfinite( weight ) || weight < 0.0 )
            fail_pixel( what, settings, i, weight );
    }
    free_rendered( &r );
    return sum;
}

double check_sane( const char* what, const RfScene* scene, const RfEye* eyes, int eye_count )
{
    RfTracer* tracer = make_tracer( scene );
    RfRenderSettings settings = small_settings( 0, 4 );
    double mean = check_sane_settings( what, tracer, eyes, eye_count, &settings );
    settings = small_settings( 2, 10 );
    for ( int n = RF_NORMALIZE_CROSSFIT; n <= RF_NORMALIZE_NONE; ++n )
    {
        settings.normalize = (RfNormalize)n;
        check_sane_settings( what, tracer, eyes, eye_count, &settings );
    }
    for ( int w = RF_WEIGHTS_EQ15; w <= RF_WEIGHTS_UNWEIGHTED; ++w )
    {
        settings.weights = (RfWeights)w;
        check_sane_settings( what, tracer, eyes, eye_count, &settings );
    }
    rf_destroy_tracer( tracer );
    return mean;
}
