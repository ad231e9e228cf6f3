// The passes of a frame as channels of its file.
#include "output/pass_channels.h"

#include "film/aov.h"

#include <string.h>

static const float s_zero = 0.0f;

static RfResult add_pass( const RfPass* pass, const RfFrameFiles* files, RfPassChannels* list, RfError* error )
{
    int letters = (int)strlen( pass->letters );
    for ( int c = 0; c < letters; ++c )
    {
        if ( list->count == RF_EXR_MAX_CHANNELS - 3 )
            return rf_fail( error, RF_ERROR_USAGE, "a frame's file cannot have more than %d channels: ask for fewer passes",
                            RF_EXR_MAX_CHANNELS );
        RfPassChannel channel;
        char *name = list->names[list->count], *part = list->parts[list->count];
        if ( pass->layer != NULL && strlen( pass->layer ) > RF_PASS_MOST )
            return rf_fail( error, RF_ERROR_USAGE, "the name of a pass is too long: '%.100s...': at most %d bytes", pass->layer,
                            RF_PASS_MOST );
        rf_name_pass_channel( files->names, pass->layer != NULL ? pass->layer : "alpha", pass->letters, c, &channel );
        strcpy( name, channel.name );
        strcpy( part, name );
        if ( pass->layer != NULL )
            *strrchr( part, '.' ) = '\0';
        bool is_colour = strcmp( pass->letters, "RGB" ) == 0,
             is_variance = pass->layer != NULL && strcmp( pass->layer, rf_aov_name( RF_AOV_VARIANCE ) ) == 0;
        bool zero = pass->zero[channel.component % 4];
        list->channels[list->count++] = ( RfExrChannel ){
            .name = name,
            .values = zero ? &s_zero : pass->values + channel.component,
            .stride = zero ? 0 : letters,
            .half = files->half && pass->half,
            .negated = channel.negated && !zero,
            .lossy = pass->half && is_colour,
            .meaning = !is_colour    ? RF_EXR_DATA
                       : is_variance ? RF_EXR_VARIANCE
                                     : RF_EXR_COLOUR,
            .component = channel.component,
            .part = files->parts == RF_PARTS_EACH && pass->layer != NULL ? part : NULL,
        };
    }
    return RF_OK;
}

RfResult rf_list_pass_channels( const RfFrameResult* frame, const RfFrameFiles* files, const bool still[2], RfPassChannels* list,
                                RfError* error )
{
    RfResult result = RF_OK;
    list->count = 0;
    for ( int i = 0; i < RF_AOV_COUNT && result == RF_OK; ++i )
    {
        RfPass pass = {
            .layer = i == RF_AOV_ALPHA ? NULL : rf_aov_name( (RfAov)i ),
            .letters = rf_aov_letters( (RfAov)i ),
            .values = frame->aovs[i],
            .half = rf_aov_is_half( (RfAov)i ),
        };
        for ( int c = 0; c < 4; ++c ) // motion is x and y to the frame before, then to the frame after
            pass.zero[c] = i == RF_AOV_MOTION && still[c / 2];
        if ( pass.values != NULL )
            result = add_pass( &pass, files, list, error );
    }
    for ( int i = 0; i < frame->layer_count && result == RF_OK; ++i )
    {
        const RfLayer* layer = frame->layers + i;
        const RfPass pass = { .layer = layer->name, .letters = layer->letters, .values = layer->values, .half = layer->half };
        result = add_pass( &pass, files, list, error );
    }
    return result;
}
