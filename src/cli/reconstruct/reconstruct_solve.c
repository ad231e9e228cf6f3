#include "cli/reconstruct/reconstruct_solve.h"

const char* const rf_reconstruct_methods[] = { "l2", "weighted", "l1", NULL };

// The method depends on what is in the file.
static RfResult choose_method( const RfReconstructChoice* choice, const RfReconstructFrame* frame, const char* name,
                               RfReconstructSolve* solve, RfError* error )
{
    bool can_weigh = frame->half_count == 2 && frame->has_variance && !choice->alpha_given;
    *solve = ( RfReconstructSolve ){ .options = rf_default_reconstruct_options(), .half_count = frame->half_count };
    solve->options.alpha = (float)choice->alpha;
    solve->options.method = choice->method_given ? (RfReconstructMethod)choice->method
                            : can_weigh          ? RF_RECONSTRUCT_WEIGHTED
                                                 : RF_RECONSTRUCT_L2;
    if ( solve->options.method != RF_RECONSTRUCT_WEIGHTED )
        return RF_OK;
    solve->own_weights = frame->half_count == 1;
    if ( choice->alpha_given )
        return rf_fail( error, RF_ERROR_USAGE, "--alpha: is of the methods l2 and l1; weighted takes weights from variances" );
    if ( !frame->has_variance )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "%s: has no channel primal.variance: name its variances by --variance A,X,Y, or choose --method l2",
                        name );
    return RF_OK;
}

// Adds the other half to the first: their mean is what the methods without weights solve.
static void average_halves( RfReconstructFrame* frame )
{
    RfImage* const images[3] = { frame->primal, frame->dx, frame->dy };
    size_t count = 3 * (size_t)frame->window.width * (size_t)frame->window.height;
    for ( int k = 0; k < 3 && frame->half_count == 2; ++k )
    {
        for ( size_t i = 0; i < count; ++i )
            images[k][0].rgb[i] = 0.5f * ( images[k][0].rgb[i] + images[k][1].rgb[i] );
    }
}

static RfGradientHalf half_of( const RfReconstructFrame* frame, int k )
{
    return ( RfGradientHalf ){ .images = rf_reconstruct_images( frame, k ),
                               .variance = frame->variance[k][0],
                               .variance_dx = frame->variance[k][1],
                               .variance_dy = frame->variance[k][2],
                               .passes = 1.0 };
}

static RfResult solve_frame( const RfReconstructSolve* solve, RfReconstructFrame* frame, float* rgb, RfReconstructInfo* info,
                             RfError* error )
{
    if ( solve->options.method == RF_RECONSTRUCT_WEIGHTED )
    {
        // a single half stands for both, so it gets its own weights
        RfGradientHalf halves[2] = { half_of( frame, 0 ), half_of( frame, solve->own_weights ? 0 : 1 ) };
        RfResult result = rf_reconstruct_halves( halves, &solve->options, rgb, NULL, info, error );
        info->biased = solve->own_weights;
        return result;
    }
    average_halves( frame );
    RfGradientImages in = rf_reconstruct_images( frame, 0 );
    return rf_reconstruct( &in, NULL, &solve->options, rgb, info, error );
}

RfResult rf_solve_frame( const RfReconstructChoice* choice, RfReconstructFrame* frame, const char* name,
                         RfReconstructSolve* solve, RfImage* image, RfReconstructInfo* info, RfError* error )
{
    RfError here;
    RfResult result = choose_method( choice, frame, name, solve, error );
    if ( result == RF_OK )
        result = rf_create_image( frame->window.width, frame->window.height, image, error );
    if ( result != RF_OK )
        return result;
    result = solve_frame( solve, frame, image->rgb, info, &here );
    if ( result == RF_OK )
        return RF_OK;
    // options are checked: what the library refuses is in the file
    return rf_fail( error, result == RF_ERROR_USAGE ? RF_ERROR_FORMAT : result, "%.400s: %.500s", name, here.text );
}
