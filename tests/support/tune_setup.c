#include "support/tune_setup.h"

#include "support/render_support.h"

void begin_tune_setup( TuneSetup* s, int eyes, int spp )
{
    s->scene = make_room( ROOM_DIFFUSE );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, TUNE_EYES, 1.0f, TUNE_WIDTH, TUNE_HEIGHT );
    for ( int i = 0; i < TUNE_EYES; ++i )
        s->frames[i] = i;
    s->settings = rf_default_render_settings();
    s->settings.filter = RF_FILTER_BOX;
    s->settings.spp = spp;
    s->settings.memory = (size_t)256 << 20;
    s->settings.threads = 2;
    s->job = ( RfTuneJob ){ .tracer = s->tracer,
                            .eyes = s->eyes,
                            .eye_count = eyes,
                            .frames = s->frames,
                            .frame_count = eyes,
                            .settings = &s->settings };
}

void end_tune_setup( TuneSetup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

int tune_rows_tried( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += tune->rows[i].excluded == NULL;
    return count;
}
