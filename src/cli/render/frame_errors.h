// The errors that finished frames have by their own estimates: their mean and the worst, for the last line and the warnings.
#ifndef REFRAME_CLI_RENDER_FRAME_ERRORS_H
#define REFRAME_CLI_RENDER_FRAME_ERRORS_H

#include "reframe/render.h"

typedef struct RfFrameErrors
{
    int frames;
    double relmse_sum;  // of the frames' estimates
    double likely_sum;  // and of their best guesses
    int lower_bounds;   // among them
    int missed;         // frames above --noise
    int flicker_missed; // and above --flicker, with the frame before
    double worst_flicker;
    int worst_pair; // its later frame
    double worst_relmse;
    int worst_frame; // its number
    bool worst_is_lower_bound;
    int roughly, not_solved;           // frames whose reconstruction stopped early, or failed
    int first_rough, first_not_solved; // the number of the first of them
} RfFrameErrors;

// Adds a finished frame of this number.
void rf_note_frame_error( RfFrameErrors* errors, const RfFrameResult* result, int number );

// Makes a frame that of the same picture as the one before it.
void rf_stop_flicker( RfFrameResult* result );

// Prints the mean over the frames as a part of a line, where there is one.
void rf_print_frame_errors( const RfFrameErrors* errors );

// Warns of reconstructions that did not converge, or failed.
void rf_warn_of_solves( const RfFrameErrors* errors, RfLog* log );

// Warns where --noise, --flicker or --time was not met.
void rf_warn_of_stop( const RfFrameErrors* errors, const RfRenderSettings* settings, const RfRenderStats* stats, int frame_count,
                      int run_count, RfLog* log );

#endif
