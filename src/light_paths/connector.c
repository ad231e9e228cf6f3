// Connections as light samples of the path tracer, by one of the normalisations.
#include "light_paths/connections.h"

const RfNormalization* rf_find_normalization( RfKernelNormalization normalization )
{
    static const RfNormalization* const rows[] = {
        [RF_KERNEL_EXACT] = &rf_exact_normalization,
        [RF_KERNEL_DISC] = &rf_disc_normalization,
        [RF_KERNEL_DENSITY] = &rf_density_normalization,
    };
    return rows[normalization];
}

static void sample( const RfConnector* connector, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* v, int vertex,
                    RfLightLanes* out, float* area )
{
    const RfLightPathConnector* self = (const RfLightPathConnector*)(const void*)connector;
    const RfConnectionLanes* connections = self->out;
    int count = rf_record_count( v );
    rf_connect_vertices( self, keys, area == NULL ? rays : NULL, v, vertex );
    float scale = RF_DELTA_PDF * (float)self->path->light_samples;
    for ( int i = 0; i < v->count; ++i )
    {
        bool found = i < count && connections->found[i] > 0;
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = found ? connections->wi[c][i] : v->n[c][i];
            out->radiance_cos[c][i] = found ? connections->one[c][i] * scale : 0.0f;
        }
        out->pdf_solid_angle[i] = found ? RF_DELTA_PDF : 1.0f;
    }
    for ( int i = 0; i < v->count && area != NULL; ++i )
        area[i] = i < count && connections->found[i] > 0 ? connections->area[i] : INFINITY;
}

RfLightPathConnector rf_make_connector( const RfLightPaths* paths, RfKernelNormalization normalization,
                                        const RfPathSettings* path, RfConnectionLanes* lanes )
{
    const RfNormalization* row = rf_find_normalization( normalization );
    return ( RfLightPathConnector ){
        .connector = { .sample = sample,
                       .vpl_connections = paths->vpl_connections,
                       .connected = paths->connected,
                       .trails = lanes->trail,
                       .weigh_chance = row->weigh_chance },
        .path = path,
        .paths = paths,
        .normalization = row,
        .out = lanes,
    };
}
