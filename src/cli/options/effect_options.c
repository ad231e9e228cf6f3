#include "cli/options/effect_options.h"

const char* const rf_effects_words[] = { "auto", "all", NULL };

// What decides on effects that cannot be left out of a scene, and what to type instead.
typedef struct Instead
{
    const char* option;
    const char* type;
} Instead;

#define AOV_ROW( constant, name, letters, half, first_hit, what )                                                                \
    [RF_EFFECT_AOV_##constant] = { "--aov " name, "leave it out of --aov" },
static const Instead s_instead[RF_EFFECT_COUNT] = {
    [RF_EFFECT_CAMERA_ANIMATION] = { NULL, "render a still by --frames 1" },
    [RF_EFFECT_SMOOTH_METALS] = { NULL, "give --no-effect chains" },
    [RF_EFFECT_LIGHT_PATHS] = { "--light-paths", "give --light-paths off" },
    [RF_EFFECT_FRAME_GROUPS] = { "--group", "give --group 0" },
    [RF_EFFECT_TILE_CONNECTIONS] = { "--tile", "give --tile 1" },
    [RF_EFFECT_ADAPTIVE] = { "--adaptive", "give --no-adaptive" },
    [RF_EFFECT_STOP_RULE] = { "--noise, --flicker, --time", "leave --noise, --flicker and --time out" },
    [RF_EFFECT_PIXEL_FILTER] = { "--filter", "give --filter box" },
    [RF_EFFECT_OTHER_PROJECTION] = { NULL, "render along a path of a camera in perspective" },
    [RF_EFFECT_GRADIENTS] = { "--estimator", "give --estimator reuse" },
    [RF_EFFECT_ALPHA] = { "--alpha", "give --no-alpha" },
    RF_AOV_LIST( AOV_ROW ) //
};
#undef AOV_ROW

const char* rf_effect_option( RfEffectId effect ) { return s_instead[effect].option; }

RfResult rf_parse_effect_options( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_effects( options->no_effect, &options->left_out, &reason );
    if ( result != RF_OK )
        return rf_fail( error, result, "--no-effect: %.1000s", reason.text );
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        RfEffectId id = (RfEffectId)i;
        if ( ( options->left_out & RF_EFFECT_BIT( i ) ) == 0 || rf_effect_without( id ) != RF_WITHOUT_IMPOSSIBLE )
            continue;
        return rf_fail( error, RF_ERROR_USAGE, "--no-effect: %s cannot be left out of a scene: %s", rf_effect_name( id ),
                        s_instead[i].type != NULL ? s_instead[i].type : rf_effect_without_text( id ) );
    }
    return RF_OK;
}

// Options may call for a lens where no camera of the scene does.
static bool may_be_called_for( const RfEffect* row )
{
    return row->on || row->id == RF_EFFECT_DEPTH_OF_FIELD || row->id == RF_EFFECT_MOTION_BLUR;
}

static void warn_of( const RfEffect* row, RfLog* log )
{
    const char* text = rf_effect_without_text( row->id );
    if ( !may_be_called_for( row ) )
        rf_warn( log, "--no-effect %s: changes nothing: %s", row->name, row->why );
    else if ( rf_effect_without( row->id ) == RF_WITHOUT_OTHER_PICTURE )
        rf_warn( log, "--no-effect %s: the picture is another than the scene asks for: %s", row->name, text );
    else
        rf_warn( log, "--no-effect %s: the picture is the same in the mean, with other noise: %s", row->name, text );
}

RfResult rf_take_effect_options( const RfRenderOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RfEffect rows[RF_MAX_EFFECTS];
    RfRenderOptions parsed = *options;
    RfResult result = rf_parse_effect_options( &parsed, error );
    if ( result != RF_OK )
        return result;
    uint64_t forced = options->effects == RF_EFFECTS_ALL ? rf_forcible_effects() & ~parsed.left_out : 0;
    int count = parsed.left_out != 0 ? rf_list_render_effects( scene, NULL, 0, &options->settings, rows ) : 0;
    result = rf_choose_effects( scene, forced, parsed.left_out, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        if ( ( parsed.left_out & RF_EFFECT_BIT( rows[i].id ) ) != 0 )
            warn_of( rows + i, log );
    }
    return result;
}
