#include "cli/render/render_settings.h"

#include "base/system.h"
#include "render/groups.h"

#include <stdio.h>

void rf_tell_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit, int path_frames )
{
    RfGroupPlan plan = rf_plan_groups( path_frames, used->group, used->spp );
    bool has_groups = used->estimator == rf_default_render_settings().estimator;
    if ( asked->group == RF_GROUP_AUTO && has_groups )
        fprintf( stderr, "reframe render: --group auto is %d here, see reframe plan\n", used->group );
    if ( asked->group > used->group )
        fprintf( stderr, "reframe render: --group %d cut to the path: groups of its %d frames\n", asked->group, plan.eyes );
    if ( asked->spp != used->spp ) // full groups only, with the same passes each
        fprintf( stderr, "reframe render: --spp %d rounded %s to %d: %d groups of %d frames hold a frame, %d sample%s in each\n",
                 asked->spp, used->spp > asked->spp ? "up" : "down", used->spp, plan.eyes, plan.eyes, plan.passes,
                 plan.passes == 1 ? "" : "s" );
    char memory[RF_BYTES_TEXT_SIZE];
    rf_format_memory( used->memory, memory );
    if ( fit->threads < used->threads )
        fprintf( stderr, "reframe render: %s of memory are enough for %d of %d threads\n", memory, fit->threads, used->threads );
    if ( fit->sweeps > 1 )
        fprintf( stderr, "reframe render: %s of memory hold the films of %d frame%s: the path is gone through %d times\n", memory,
                 fit->films, fit->films == 1 ? "" : "s", fit->sweeps );
}

static uint64_t set_of( const RfEffect* effects, int count, bool left_out, bool forced )
{
    uint64_t set = 0;
    for ( int i = 0; i < count; ++i )
    {
        const RfEffect* e = effects + i;
        bool listed = left_out ? e->left_out : forced ? e->forced : e->on;
        set |= listed ? RF_EFFECT_BIT( e->id ) : 0;
    }
    return set;
}

void rf_tell_effects( const RfEffect* effects, int count )
{
    char on[RF_EFFECTS_TEXT_SIZE], out[RF_EFFECTS_TEXT_SIZE], forced[RF_EFFECTS_TEXT_SIZE];
    rf_format_effects( set_of( effects, count, false, false ), on, sizeof on );
    rf_format_effects( set_of( effects, count, true, false ), out, sizeof out );
    rf_format_effects( set_of( effects, count, false, true ), forced, sizeof forced );
    fprintf( stderr, "reframe render: effects: %s%s%s%s%s\n", on[0] != '\0' ? on : "none", out[0] != '\0' ? "; left out: " : "",
             out, forced[0] != '\0' ? "; forced: " : "", forced );
}

void rf_tell_runs( const RfCameraPath* path, const int* frames, int frame_count, int run_count )
{
    int stretches = 0, first = 0, last = 0;
    if ( run_count == frame_count )
        return;
    for ( int i = 1; i < frame_count; ++i )
    {
        if ( path->run_of_frame[frames[i]] != path->run_of_frame[frames[i - 1]] )
            continue;
        bool begins = i == 1 || path->run_of_frame[frames[i - 1]] != path->run_of_frame[frames[i - 2]];
        stretches += begins;
        first = begins && stretches == 1 ? frames[i - 1] : first;
        last = stretches == 1 ? frames[i] : last;
    }
    char more[48] = "";
    if ( stretches > 1 )
        snprintf( more, sizeof more, " and %d more times", stretches - 1 );
    fprintf( stderr,
             "reframe render: the camera stands still in frames %d to %d%s: equal frames are rendered once, %d of %d in all\n",
             rf_frame_number( path, first ), rf_frame_number( path, last ), more, run_count, frame_count );
}
