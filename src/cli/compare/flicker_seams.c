#include "cli/compare/flicker_seams.h"

#include "cli/options/options.h"
#include "reframe/image.h"

#define MOST_FRAMES 10000000

static bool read_whole( const char* path, const char* name, long long min, long long max, int* value )
{
    char text[32];
    long long whole;
    if ( rf_read_exr_string( path, name, text, sizeof text, NULL ) != RF_OK || !rf_parse_whole( text, min, max, &whole ) )
        return false;
    *value = (int)whole;
    return true;
}

RfSeams rf_read_seams( const char* path, int number, int last )
{
    RfSeams seams = { 0 };
    int group, spp, frame, frames;
    if ( !read_whole( path, "reframe/group", 1, MOST_FRAMES, &group ) || !read_whole( path, "reframe/spp", 1, 1 << 20, &spp ) ||
         !read_whole( path, "reframe/frame", 1, MOST_FRAMES, &frame ) )
        return seams;
    seams.first = number - ( frame - 1 );
    if ( !read_whole( path, "reframe/frames", 1, MOST_FRAMES, &frames ) )
        frames = last - seams.first + 1;
    if ( frames < frame )
        return seams;
    seams.slides = true;
    seams.plan = rf_plan_groups( frames, group, spp );
    return seams;
}

RfSeams rf_fixed_seams( int period, int first ) { return ( RfSeams ){ .period = period, .first = first }; }
