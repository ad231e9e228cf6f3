#include "gradient/check.h"

#include "base/fault.h"

#include <math.h>

RfResult rf_check_reconstruct_options( const RfReconstructOptions* options, bool has_weights, RfError* error )
{
    bool weighted = options->method == RF_RECONSTRUCT_WEIGHTED;
    if ( weighted != has_weights )
        return rf_fail( error, RF_ERROR_USAGE,
                        weighted ? "the weighted reconstruction wants weights, and got none"
                                 : "weights are of the weighted reconstruction, not of the others" );
    // a square of alpha that is no float or drowns in the gradients says nothing of the image
    if ( !weighted && ( !isgreaterequal( options->alpha, 1e-4f ) || !islessequal( options->alpha, 1e4f ) ) )
        return rf_fail( error, RF_ERROR_USAGE, "alpha is %g: choose one from 0.0001 to 10000", (double)options->alpha );
    if ( options->method != RF_RECONSTRUCT_L2 && ( !isgreater( options->tolerance, 0.0 ) || options->max_iterations < 1 ) )
        return rf_fail( error, RF_ERROR_USAGE, "the tolerance must be above 0 and the iterations at least 1, got %g and %d",
                        options->tolerance, options->max_iterations );
    if ( options->method == RF_RECONSTRUCT_L1 && options->l1_rounds < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "L1 wants at least 1 round, got %d", options->l1_rounds );
    return RF_OK;
}

RfResult rf_check_plane( const float* plane, int width, int height, int skip_x, int skip_y, const char* what, RfError* error )
{
    for ( int y = 0; y < height - skip_y; ++y )
    {
        for ( int x = 0; x < width - skip_x; ++x )
        {
            float value = plane[(size_t)y * (size_t)width + (size_t)x];
            if ( !isgreaterequal( value, 0.0f ) || !islessequal( value, 3.4e38f ) )
                return rf_fail( error, RF_ERROR_USAGE, "%s: %g at pixel (%d, %d): must be finite and at least 0", what,
                                (double)value, x, y );
        }
    }
    return RF_OK;
}

// The largest magnitude among data of weight > 0 goes to *largest.
static RfResult check_data( const float* rgb, const float* weights, const RfGradientImages* in, int skip_x, int skip_y,
                            const char* what, float* largest, RfError* error )
{
    for ( int y = 0; y < in->height - skip_y; ++y )
    {
        for ( int x = 0; x < in->width - skip_x; ++x )
        {
            size_t i = (size_t)y * (size_t)in->width + (size_t)x;
            if ( weights != NULL && !( weights[i] > 0.0f ) )
                continue;
            for ( size_t c = 0; c < 3; ++c )
            {
                float value = fabsf( rgb[3 * i + c] );
                if ( !isfinite( value ) )
                    return rf_fail( error, RF_ERROR_USAGE, "%s: %s at pixel (%d, %d), which no reconstruction survives", what,
                                    isnan( value ) ? "NaN" : "infinity", x, y );
                *largest = value > *largest ? value : *largest;
            }
        }
    }
    return RF_OK;
}

RfResult rf_check_gradients( const RfGradientImages* in, const RfGradientWeights* weights, float* scale, RfError* error )
{
    const float *a = weights != NULL ? weights->a : NULL, *b_x = weights != NULL ? weights->b_x : NULL,
                *b_y = weights != NULL ? weights->b_y : NULL;
    float largest = 0.0f;
    int w = in->width, h = in->height;
    if ( w < 1 || h < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "an image of %dx%d pixels cannot be reconstructed", w, h );
    RfResult result = RF_OK;
    if ( weights != NULL )
        result = rf_check_plane( a, w, h, 0, 0, "weight of the primal", error );
    if ( result == RF_OK && weights != NULL )
        result = rf_check_plane( b_x, w, h, 1, 0, "weight of dx", error );
    if ( result == RF_OK && weights != NULL )
        result = rf_check_plane( b_y, w, h, 0, 1, "weight of dy", error );
    if ( result == RF_OK )
        result = check_data( in->primal, a, in, 0, 0, "primal", &largest, error );
    if ( result == RF_OK )
        result = check_data( in->dx, b_x, in, 1, 0, "dx", &largest, error );
    if ( result == RF_OK )
        result = check_data( in->dy, b_y, in, 0, 1, "dy", &largest, error );
    int exponent = 0;
    if ( largest > 0.0f )
        frexpf( largest, &exponent );
    exponent = exponent < -120 ? -120 : exponent > 120 ? 120 : exponent;
    *scale = RF_FAULT( poisson_scale ) ? 1.0f : ldexpf( 1.0f, -exponent );
    return result;
}
