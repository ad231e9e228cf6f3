#include "output/frame_aovs.h"

#include "film/aov.h"

#include <stdio.h>

#define NAME_FITS( constant, name, letters, half, first_hit, what )                                                              \
    _Static_assert( sizeof( name ) + 2 <= RF_AOV_CHANNEL_NAME_SIZE, "the names of its channels fit" );
RF_AOV_LIST( NAME_FITS )
#undef NAME_FITS

static const float s_zero = 0.0f;

void rf_list_aov_channels( const RfFrameResult* frame, bool half, const bool still[2], RfAovChannels* list )
{
    list->count = 0;
    for ( int i = 0; i < RF_AOV_COUNT; ++i )
    {
        const char* letters = rf_aov_letters( (RfAov)i );
        int channels = frame->aovs[i] != NULL ? rf_aov_channels( (RfAov)i ) : 0;
        for ( int c = 0; c < channels; ++c )
        {
            char* name = list->names[list->count];
            // motion is x and y to the frame before, then to the frame after
            bool zero = i == RF_AOV_MOTION && still[c / 2];
            const char* layer = i == RF_AOV_ALPHA ? "" : rf_aov_name( (RfAov)i );
            snprintf( name, sizeof list->names[0], "%s%s%c", layer, layer[0] != '\0' ? "." : "", letters[c] );
            list->channels[list->count++] = ( RfExrChannel ){
                .name = name,
                .values = zero ? &s_zero : frame->aovs[i] + c,
                .stride = zero ? 0 : channels,
                .half = half && rf_aov_is_half( (RfAov)i ),
            };
        }
    }
}
