// Words of settings; names of passes, by a table and rules for light groups and for what is not in it; time codes of frames, with and
// without dropped numbers.
#include "output/names.h"

#include "film/pixel_filter.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char* const rf_weights_words[] = {
    [RF_WEIGHTS_EXACT] = "exact", [RF_WEIGHTS_EQ15] = "eq15", [RF_WEIGHTS_UNWEIGHTED] = "unweighted", NULL
};
const char* const rf_normalize_words[] = {
    [RF_NORMALIZE_CROSSFIT] = "crossfit", [RF_NORMALIZE_RATIO] = "ratio", [RF_NORMALIZE_NONE] = "none", NULL
};
const char* const rf_light_paths_words[] = {
    [RF_LIGHT_PATHS_ON] = "on",
    [RF_LIGHT_PATHS_OFF] = "off",
    NULL,
};
const char* const rf_kernel_normalization_words[] = {
    [RF_KERNEL_EXACT] = "exact",
    [RF_KERNEL_DISC] = "disc",
    [RF_KERNEL_DENSITY] = "density",
    NULL,
};
const char* const rf_reconstruction_words[] = {
    [RF_RECONSTRUCTION_WEIGHTED] = "weighted",
    [RF_RECONSTRUCTION_L2] = "l2",
    [RF_RECONSTRUCTION_L1] = "l1",
    [RF_RECONSTRUCTION_NONE] = "none",
    NULL,
};
const char* const rf_guiding_words[] = { [RF_GUIDE_AUTO] = "auto", [RF_GUIDE_ON] = "on", [RF_GUIDE_OFF] = "off", NULL };
const char* const rf_adaptive_words[] = { [RF_ADAPTIVE_AUTO] = "auto", [RF_ADAPTIVE_ON] = "on", [RF_ADAPTIVE_OFF] = "off", NULL };
const char* const rf_pass_names_words[] = {
    [RF_NAMES_REFRAME] = "reframe",
    [RF_NAMES_BLENDER] = "blender",
    [RF_NAMES_BLENDER_5] = "blender5",
    [RF_NAMES_NUKE] = "nuke",
    NULL,
};
const char* const rf_parts_words[] = { [RF_PARTS_ONE] = "one", [RF_PARTS_EACH] = "each", NULL };

bool rf_is_other_estimator( const RfEstimator* estimator )
{
    return strcmp( rf_estimator_name( estimator ), rf_estimator_name( rf_default_render_settings().estimator ) ) != 0;
}

const char* rf_weights_name( RfWeights weights ) { return rf_weights_words[weights]; }

const char* rf_normalize_name( RfNormalize normalize ) { return rf_normalize_words[normalize]; }

const char* rf_light_paths_name( RfLightPathsUse use ) { return rf_light_paths_words[use]; }
const char* rf_kernel_normalization_name( RfKernelNormalization normalization )
{
    return rf_kernel_normalization_words[normalization];
}
const char* rf_reconstruction_name( RfReconstruction reconstruction ) { return rf_reconstruction_words[reconstruction]; }

const char* rf_filter_name( RfFilter filter ) { return rf_filter_words[filter]; }

const char* rf_guiding_name( RfGuiding guiding ) { return rf_guiding_words[guiding]; }
const char* rf_adaptive_name( RfAdaptive adaptive ) { return rf_adaptive_words[adaptive]; }

// A pass that Blender or Nuke has under a name of its own. NULL: not that program.
typedef struct Row
{
    const char* pass;
    const char* blender;   // after "ViewLayer."
    const char* blender_5; // from Blender 5.0 on; NULL: the same
    int component[4];      // of the pass, of each of Blender's channels, from 1 on; below 0: negated. 0: in order
    const char* nuke[4];   // full names
} Row;

static const Row s_rows[] = {
    { .pass = RF_PASS_PICTURE, .blender = "Combined", .nuke = { "R", "G", "B" } },
    { .pass = "alpha", .blender = "Combined", .nuke = { "A" } },
    { .pass = "albedo", .blender = "DiffCol", .blender_5 = "Diffuse Color" },
    { .pass = "denoise_albedo", .blender = "Denoising Albedo" },
    { .pass = "denoise_normal", .blender = "Denoising Normal", .component = { 1, -3, 2 } },
    { .pass = "normal", .blender = "Normal", .component = { 1, -3, 2 } },
    { .pass = "depth", .blender = "Depth" },
    { .pass = "motion",
      .blender = "Vector",
      .component = { 1, 2, -3, -4 },
      .nuke = { "backward.u", "backward.v", "forward.u", "forward.v" } },
    { .pass = "emission", .blender = "Emit", .blender_5 = "Emission" },
    { .pass = "object_index", .blender = "IndexOB", .blender_5 = "Object Index" },
    { .pass = "material_index", .blender = "IndexMA", .blender_5 = "Material Index" },
};

#define ROWS ( sizeof s_rows / sizeof s_rows[0] )
#define BLENDER_LIGHT "Combined_"

static bool is_blender( RfPassNames names ) { return names == RF_NAMES_BLENDER || names == RF_NAMES_BLENDER_5; }

static bool begins( const char* text, const char* with ) { return strncmp( text, with, strlen( with ) ) == 0; }

static const Row* find_row( const char* pass )
{
    for ( size_t i = 0; i < ROWS; ++i )
    {
        if ( strcmp( s_rows[i].pass, pass ) == 0 )
            return s_rows + i;
    }
    return NULL;
}

// Blender takes what is behind the last dot but one for the pass: there are none in its name.
static void put_blender_layer( RfPassNames names, const char* pass, char name[RF_PASS_CHANNEL_SIZE] )
{
    const Row* row = find_row( pass );
    bool light = row == NULL && begins( pass, RF_LIGHT_LAYER );
    const char* own = row == NULL                                             ? ( light ? pass + strlen( RF_LIGHT_LAYER ) : pass )
                      : names == RF_NAMES_BLENDER_5 && row->blender_5 != NULL ? row->blender_5
                                                                              : row->blender;
    size_t begin = strlen( RF_BLENDER_LAYER "." );
    snprintf( name, RF_PASS_CHANNEL_SIZE, RF_BLENDER_LAYER ".%s%.200s", light ? BLENDER_LIGHT : "", own );
    for ( char* c = name + begin; *c != '\0'; ++c )
        *c = *c == '.' ? '_' : *c;
}

void rf_name_pass_layer( RfPassNames names, const char* pass, char name[RF_PASS_CHANNEL_SIZE] )
{
    if ( is_blender( names ) )
        put_blender_layer( names, pass, name );
    else
        snprintf( name, RF_PASS_CHANNEL_SIZE, "%.200s", pass );
}

static void name_blender_channel( RfPassNames names, const char* pass, const char* letters, int i, RfPassChannel* channel )
{
    const Row* row = find_row( pass );
    char layer[RF_PASS_CHANNEL_SIZE];
    int component = row != NULL ? row->component[i] : 0;
    put_blender_layer( names, pass, layer );
    snprintf( channel->name, sizeof channel->name, "%.240s.%c", layer, letters[i] );
    channel->component = component == 0 ? i : ( component < 0 ? -component : component ) - 1;
    channel->negated = component < 0;
}

void rf_name_pass_channel( RfPassNames names, const char* pass, const char* letters, int i, RfPassChannel* channel )
{
    if ( is_blender( names ) )
    {
        name_blender_channel( names, pass, letters, i, channel );
        return;
    }
    const Row* row = find_row( pass );
    const char* nuke = names == RF_NAMES_NUKE && row != NULL ? row->nuke[i] : NULL;
    bool bare = pass[0] == '\0' || strcmp( pass, "alpha" ) == 0;
    *channel = ( RfPassChannel ){ .component = i };
    if ( nuke != NULL )
        snprintf( channel->name, sizeof channel->name, "%s", nuke );
    else
        snprintf( channel->name, sizeof channel->name, "%.200s%s%c", bare ? "" : pass, bare ? "" : ".", letters[i] );
}

// The end of a name, which may have anything and a dot before it.
static bool ends( const char* name, const char* tail )
{
    size_t length = strlen( name ), end = strlen( tail );
    return length >= end && strcmp( name + length - end, tail ) == 0 && ( length == end || name[length - end - 1] == '.' );
}

static bool is_blender_channel( RfPassNames names, const char* channel, const char* pass, char letter, bool* negated )
{
    static const char letters[] = "XYZW";
    const Row* row = find_row( pass );
    char layer[RF_PASS_CHANNEL_SIZE], tail[RF_PASS_CHANNEL_SIZE + 2];
    put_blender_layer( names, pass, layer );
    for ( int i = 0; row != NULL && row->component[0] != 0 && i < 4; ++i )
    {
        int component = row->component[i];
        if ( component == 0 || letters[( component < 0 ? -component : component ) - 1] != letter )
            continue;
        letter = letters[i];
        *negated = component < 0;
        break;
    }
    snprintf( tail, sizeof tail, "%s.%c", layer + strlen( RF_BLENDER_LAYER "." ), letter );
    return ends( channel, tail );
}

bool rf_is_pass_channel( const char* channel, const char* pass, char letter, bool* negated )
{
    static const char letters[] = "XYZW";
    const Row* row = find_row( pass );
    const char letter_text[] = { letter, '\0' };
    RfPassChannel own;
    rf_name_pass_channel( RF_NAMES_REFRAME, pass, letter_text, 0, &own );
    *negated = false;
    bool bare = strchr( own.name, '.' ) == NULL; // "R": at the end of many
    if ( bare ? strcmp( channel, own.name ) == 0 : ends( channel, own.name ) )
        return true;
    for ( int i = 0; row != NULL && !bare && i < 4; ++i )
    {
        if ( row->nuke[i] != NULL && letters[i] == letter && ends( channel, row->nuke[i] ) )
            return true;
    }
    if ( is_blender_channel( RF_NAMES_BLENDER, channel, pass, letter, negated ) ||
         is_blender_channel( RF_NAMES_BLENDER_5, channel, pass, letter, negated ) )
        return true;
    *negated = false;
    return strcmp( pass, "depth" ) == 0 && ends( channel, "Depth.V" );
}

#define DAY 86400 // seconds

#define DROP_FLAG ( 1u << 6 )
#define FIELD_MARK ( 1u << 15 )

// Numbers that a minute drops.
static int dropped( RfTimeCodeRate rate ) { return rate.drops ? rate.frames / 15 : 0; }

static bool is_fraction( RfFps fps, int frames )
{
    return fabs( (double)fps.numerator / fps.denominator - frames ) > 1e-6 * frames;
}

RfTimeCodeRate rf_time_code_rate( RfFps fps )
{
    RfTimeCodeRate rate = { 0 };
    if ( fps.numerator < 1 || fps.denominator < 1 )
        return rate;
    double whole = (double)fps.numerator / fps.denominator, slow = 1.001 * whole;
    // 29.97 and 23.976 stand for 30000/1001 and 24000/1001
    double frames = fabs( whole - round( whole ) ) < 1e-6 ? round( whole )
                    : fabs( slow - round( slow ) ) < 1e-3 ? round( slow )
                                                          : 0.0;
    if ( ( frames >= 1.0 && frames <= 30.0 ) || frames == 48.0 || frames == 50.0 || frames == 60.0 )
        rate.frames = (int)frames;
    return rate;
}

RfResult rf_parse_time_code( const char* text, RfFps fps, RfTimeCodeRate* rate, int64_t* frames, RfError* error )
{
    static const int most[4] = { 23, 59, 59, 99 };
    int field[4] = { 0 };
    bool right = strlen( text ) == 11 && text[2] == ':' && text[5] == ':' && ( text[8] == ':' || text[8] == ';' );
    for ( int i = 0; right && i < 4; ++i )
    {
        const char* digits = text + 3 * i;
        field[i] = 10 * ( digits[0] - '0' ) + digits[1] - '0';
        right = strspn( digits, "0123456789" ) == 2 && field[i] <= most[i];
    }
    *rate = rf_time_code_rate( fps );
    *frames = 0;
    if ( !right )
        return rf_fail( error, RF_ERROR_USAGE, "expected HH:MM:SS:FF, as 01:00:00:00, got '%.40s'", text );
    double per_second = (double)fps.numerator / fps.denominator;
    if ( rate->frames == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "no time code of %g frames per second: leave it out", per_second );
    if ( field[3] >= rate->frames )
        return rf_fail( error, RF_ERROR_USAGE, "%s: at %g frames per second the last number is %02d", text, per_second,
                        rate->frames - 1 );
    rate->drops = text[8] == ';';
    if ( rate->drops && ( rate->frames % 30 != 0 || !is_fraction( fps, rate->frames ) ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "%s: only at 29.97 and 59.94 frames per second numbers are dropped: write it as %.8s:%s", text, text,
                        text + 9 );
    int minutes = 60 * field[0] + field[1], drop = dropped( *rate );
    if ( field[1] % 10 != 0 && field[2] == 0 && field[3] < drop )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is dropped in drop-frame time code: the minute begins with %.9s%02d", text,
                        text, drop );
    *frames = ( 60 * (int64_t)minutes + field[2] ) * rate->frames + field[3] - (int64_t)drop * ( minutes - minutes / 10 );
    return RF_OK;
}

static uint32_t bcd( int64_t value ) { return (uint32_t)( value / 10 % 10 ) << 4 | (uint32_t)( value % 10 ); }

uint32_t rf_pack_time_code( RfTimeCodeRate rate, int64_t frames )
{
    if ( rate.frames == 0 )
        return 0;
    int64_t drop = dropped( rate ), minute = 60 * (int64_t)rate.frames - drop, ten = 10 * minute + drop;
    int64_t day = rate.drops ? 144 * ten : DAY * (int64_t)rate.frames, n = ( frames % day + day ) % day, rest = n % ten;
    n += rate.drops ? 9 * drop * ( n / ten ) + ( rest >= drop ? drop * ( ( rest - drop ) / minute ) : 0 ) : 0;
    int64_t number = n % rate.frames, seconds = n / rate.frames;
    bool pairs = rate.frames > 30;
    uint32_t packed = bcd( pairs ? number / 2 : number ) | bcd( seconds % 60 ) << 8 | bcd( seconds / 60 % 60 ) << 16 |
                      bcd( seconds / 3600 ) << 24;
    return packed | ( rate.drops ? DROP_FLAG : 0 ) | ( pairs && number % 2 != 0 ? FIELD_MARK : 0 );
}
