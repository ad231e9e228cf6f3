// Progress on standard error: one line rewritten in place on a terminal, plain
// lines otherwise.
#ifndef REFRAME_CLI_RENDER_PROGRESS_H
#define REFRAME_CLI_RENDER_PROGRESS_H

#include "reframe/render.h"

typedef struct RfProgressLine
{
    bool quiet;
    bool terminal;
    double shown; // seconds at which the line was last written
    int width;    // characters of it
} RfProgressLine;

RfProgressLine rf_create_progress_line( bool quiet );

// Shows "frame 12/48  25 %  0:14 spent  0:42 left  noise 3.2 % (relMSE 0.0031)", with the
// estimated error of the last finished frame, at most ten times a second. The rate is left out
// where the line would exceed 80 columns. Where standard error is no terminal: a plain line
// every ten seconds.
void rf_show_progress( RfProgressLine* line, const RfProgress* progress );

// Prints a plain line for a finished frame called `number`, the `done`-th of `all`, after so many seconds of
// rendering, where standard error is no terminal.
void rf_show_frame( RfProgressLine* line, const RfFrameResult* result, int number, int done, int all, double seconds );

// Clears the line before another message.
void rf_clear_progress( RfProgressLine* line );

// "3 of 48 frames", rewritten in place, for commands that go through a sequence;
// nothing where standard error is no terminal, or `quiet`.
void rf_show_frame_count( bool quiet, int done, int all );

// Writes the line's text (for the tests).
void rf_format_progress( const RfProgress* progress, char* text, size_t size );

#endif
