#include "cli/render/render_settings.h"

#include "base/system.h"
#include "render/groups.h"

#include <stdio.h>

void rf_tell_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit, int path_frames )
{
    RfGroupPlan plan = rf_plan_groups( path_frames, used->group, used->spp );
    if ( asked->group == RF_GROUP_AUTO )
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
