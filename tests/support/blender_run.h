// Blender for tests: that of the path, or the one that the environment variable REFRAME_BLENDER names.
#ifndef REFRAME_TESTS_BLENDER_RUN_H
#define REFRAME_TESTS_BLENDER_RUN_H

#include "support/cli_run.h"

#include <stdio.h>
#include <stdlib.h>

// another Python first in the path would hide the numpy of Debian's
#define BLENDER "PATH=/usr/bin:$PATH ${REFRAME_BLENDER:-blender} -b "
#define BLENDER_SCRIPT REFRAME_SOURCE_DIR "/scripts/blender/export.py -- "
// Runs a script of tests/support/ in an empty Blender.
#define BLENDER_MAKE BLENDER "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR "/tests/support/"

// Enters a folder if there is a Blender with numpy; else says that the test is skipped.
static inline bool enter_with_blender( void )
{
    cli_enter();
    if ( cli_run( BLENDER "--factory-startup --python-exit-code 9 --python-expr 'import numpy' > log 2>&1" )->status == 0 )
        return true;
    cli_leave();
    printf( "skipped: there is no blender with numpy\n" );
    fflush( stdout ); // or children print it again
    return false;
}

// Its version before the point, outside of a folder; 0 without Blender.
static inline int blender_major( void )
{
    cli_enter();
    const CliResult* done = cli_run( BLENDER "--version 2> log | sed -n 's/^Blender \\([0-9]*\\)[.].*/\\1/p' | head -1" );
    int major = atoi( done->out );
    cli_leave();
    return major;
}

#endif
