// reframe png: EXR files as PNG, to look at: their colour, a pass, the light groups mixed anew, or the matte of a name.
#include "base/try.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "cli/view/view.h"
#include "image/encode.h"
#include "page/pass_groups.h"
#include "page/picture.h"
#include "reframe/output.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum PngKind
{
    RF_PNG_COLOUR,
    RF_PNG_PASS,
    RF_PNG_VALUES, // of a channel, or three, as they are
    RF_PNG_MIX,
    RF_PNG_MATTE,
} PngKind;

#define RF_PNG_MOST_FACTORS 32

typedef struct PngPicture
{
    const char *layer, *matte, *mix; // options; NULL: not given
    bool data_window;                // all pixels of the file, not its display window alone

    // Found by find_png_picture.
    PngKind kind;
    bool takes_view;     // it is light, or values that may be
    bool takes_exposure; // the same, or bright as light is
    RfLookRange range;   // of the pass, over some frames
    char crypto[64];     // the Cryptomatte with the matte, and its id
    uint32_t id;
    char names[RF_PNG_MOST_FACTORS][64]; // of --mix
    float factors[RF_PNG_MOST_FACTORS];
    int factor_count;

    const RfView* view; // NULL: the sRGB curve
    double exposure;    // without a view; a view has its own
} PngPicture;

#define GROUP "light_"
#define MOST_PIXELS 268435456.0 // of a picture: 3 GiB of floats

// A file's header and passes.
typedef struct PngFile
{
    const char* path;
    RfExrHeader header;
    RfFilePasses passes;
} PngFile;

static RfResult open_file( const char* path, PngFile* file, RfError* error )
{
    *file = ( PngFile ){ .path = path };
    RF_TRY( rf_read_exr_header( path, NULL, &file->header, error ) );
    return rf_list_passes( &file->header, &file->passes, error );
}

static void close_file( PngFile* file )
{
    rf_free_passes( &file->passes );
    rf_destroy_exr_header( &file->header );
}

static int compare_words( const void* a, const void* b ) { return strcmp( *(char* const*)a, *(char* const*)b ); }

// Sorts the words, of which there is at least one.
static RfResult fail_unknown( const char* path, const char* what, const char* word, const char** words, int count,
                              RfError* error )
{
    const char* nearest = rf_nearest_word( word, words, count );
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%.400s: has no %s '%.80s', did you mean '%.80s'?", path, what, word, nearest );
    qsort( words, (size_t)count, sizeof *words, compare_words );
    char all[512] = "";
    bool fits = true;
    for ( int i = 0; i < count && fits; ++i )
    {
        size_t used = strlen( all );
        bool is_new = i == 0 || strcmp( words[i - 1], words[i] ) != 0; // an object and its material may have the same name
        fits = used + strlen( words[i] ) + 8 < sizeof all;
        if ( is_new )
            snprintf( all + used, sizeof all - used, "%s%s", used > 0 ? ", " : "", fits ? words[i] : "..." );
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%.300s: has no %s '%.80s', there are %s", path, what, word, all );
}

static const char* group_name( const RfFilePass* pass )
{
    return strncmp( pass->name, GROUP, strlen( GROUP ) ) == 0 ? pass->name + strlen( GROUP ) : pass->name;
}

// "key=0.3,fill=2".
static RfResult parse_factors( PngPicture* picture, RfError* error )
{
    for ( const char* text = picture->mix; text != NULL; )
    {
        size_t length = strcspn( text, "," ), name = strcspn( text, "=" );
        char *end = NULL, *to = picture->names[picture->factor_count % RF_PNG_MOST_FACTORS];
        double factor = name < length ? strtod( text + name + 1, &end ) : 0.0;
        if ( name == 0 || name >= length || name >= sizeof picture->names[0] || end != text + length || end == text + name + 1 ||
             !isfinite( factor ) || factor < 0.0 || factor > 1e6 || picture->factor_count == RF_PNG_MOST_FACTORS )
            return rf_fail( error, RF_ERROR_USAGE, "--mix: expected groups and factors, such as key=0.3,fill=2, got '%.200s'",
                            picture->mix );
        snprintf( to, sizeof picture->names[0], "%.*s", (int)name, text );
        for ( int i = 0; i < picture->factor_count; ++i )
        {
            if ( strcmp( picture->names[i], to ) == 0 )
                return rf_fail( error, RF_ERROR_USAGE, "--mix: the group %s is given twice", to );
        }
        picture->factors[picture->factor_count++] = (float)factor;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

static RfResult check_groups( const PngPicture* picture, const PngFile* file, RfError* error )
{
    const char** names = malloc( ( (size_t)file->passes.count + 1 ) * sizeof *names );
    int count = 0;
    RfResult result = names != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of light groups" );
    for ( int i = 0; i < file->passes.count && result == RF_OK; ++i )
    {
        if ( file->passes.passes[i].is_group )
            names[count++] = group_name( file->passes.passes + i );
    }
    if ( result == RF_OK && count == 0 )
        result = rf_fail( error, RF_ERROR_FORMAT, "%s: has no light groups: render them by --light-groups", file->path );
    for ( int i = 0; i < picture->factor_count && result == RF_OK; ++i )
    {
        bool found = false;
        for ( int k = 0; k < count; ++k )
            found |= strcmp( names[k], picture->names[i] ) == 0;
        if ( !found )
            result = fail_unknown( file->path, "light group", picture->names[i], names, count, error );
    }
    free( names );
    return result;
}

static float factor_of( const PngPicture* picture, const RfFilePass* pass )
{
    for ( int i = 0; i < picture->factor_count; ++i )
    {
        if ( strcmp( picture->names[i], group_name( pass ) ) == 0 )
            return picture->factors[i];
    }
    return 1.0f;
}

// The sum of the groups with their factors.
static RfResult mix_groups( const PngPicture* picture, const PngFile* file, RfImage* image, RfExrWindow* window, RfError* error )
{
    RfResult result = check_groups( picture, file, error );
    for ( int i = 0; i < file->passes.count && result == RF_OK; ++i )
    {
        const RfFilePass* pass = file->passes.passes + i;
        float *values = NULL, factor = factor_of( picture, pass );
        int stride;
        if ( !pass->is_group )
            continue;
        result = rf_read_passes( file->path, pass, 1, window, &values, &stride, error );
        if ( result == RF_OK && image->rgb == NULL )
            result = rf_create_image( window->width, window->height, image, error );
        size_t count = 3 * (size_t)image->width * (size_t)image->height;
        if ( result == RF_OK && ( image->width != window->width || image->height != window->height ) )
            result = rf_fail( error, RF_ERROR_FORMAT, "%s: the light groups differ in size", file->path );
        for ( size_t k = 0; k < count && result == RF_OK; ++k )
            image->rgb[k] += factor * values[k];
        free( values );
    }
    return result;
}

// Objects before materials and assets.
static int order_of( const RfFilePass* pass )
{
    return strstr( pass->name, "Object" ) != NULL ? 0 : strstr( pass->name, "Material" ) != NULL ? 1 : 2;
}

typedef struct Words
{
    char** words;
    int count, best;
} Words;

static RfResult look_for_matte( PngPicture* picture, const PngFile* file, const RfFilePass* pass, Words* all, RfError* error )
{
    RfMatteNames names;
    RfResult result = rf_read_matte_names( file->path, pass, &names, error );
    char** more = realloc( all->words, (size_t)( all->count + names.count + 1 ) * sizeof *more );
    if ( result == RF_OK && more == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the names of its Cryptomatte", file->path );
    all->words = more != NULL ? more : all->words;
    for ( int i = 0; i < names.count && result == RF_OK; ++i )
    {
        if ( strcmp( names.names[i].name, picture->matte ) == 0 && order_of( pass ) < all->best )
        {
            all->best = order_of( pass );
            picture->id = names.names[i].id;
            snprintf( picture->crypto, sizeof picture->crypto, "%.63s", pass->name );
        }
        all->words[all->count++] = names.names[i].name;
        names.names[i].name = NULL; // it is ours now
    }
    rf_free_matte_names( &names );
    return result;
}

static RfResult find_matte( PngPicture* picture, const PngFile* file, RfError* error )
{
    Words all = { .best = 3 };
    RfResult result = RF_OK;
    for ( int i = 0; i < file->passes.count && result == RF_OK; ++i )
    {
        const RfFilePass* pass = file->passes.passes + i;
        if ( pass->look == RF_LOOK_MATTES && ( picture->layer == NULL || strcmp( picture->layer, pass->name ) == 0 ) )
            result = look_for_matte( picture, file, pass, &all, error );
    }
    if ( result == RF_OK && all.count == 0 )
        result = rf_fail( error, RF_ERROR_FORMAT, "%s: has no Cryptomatte%s%.100s with names: render it by --cryptomatte",
                          file->path, picture->layer != NULL ? " " : "", picture->layer != NULL ? picture->layer : "" );
    else if ( result == RF_OK && all.best == 3 )
        result = fail_unknown( file->path, "matte", picture->matte, (const char**)all.words, all.count, error );
    for ( int i = 0; i < all.count; ++i )
        free( all.words[i] );
    free( all.words );
    return result;
}

// The part of each pixel that the id covers, as light that the sRGB curve shows as grey of that level.
static RfResult draw_matte( const PngPicture* picture, const PngFile* file, RfImage* image, RfExrWindow* window, RfError* error )
{
    const RfFilePass* pass = rf_find_pass( &file->passes, picture->crypto );
    float* values;
    int stride;
    if ( pass == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: has no %s", file->path, picture->crypto );
    RfResult result = rf_read_passes( file->path, pass, 1, window, &values, &stride, error );
    if ( result == RF_OK )
        result = rf_create_image( window->width, window->height, image, error );
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < pixels && result == RF_OK; ++i )
    {
        float covered = 0.0f;
        for ( int pair = 0; pair < stride / 2; ++pair )
        {
            const float* v = values + (size_t)stride * i + 2 * pair;
            covered += memcmp( v, &picture->id, sizeof *v ) == 0 ? v[1] : 0.0f;
        }
        rf_draw_look( RF_LOOK_SHARE, ( RfLookRange ){ 0.0f, 1.0f }, &covered, 1, 1, image->rgb + 3 * i );
    }
    free( values );
    return result;
}

static RfResult draw_pass( const PngPicture* picture, const PngFile* file, RfImage* image, RfExrWindow* window, RfError* error )
{
    const RfFilePass* pass = rf_find_pass( &file->passes, picture->layer );
    float* values;
    int stride;
    char all[600];
    rf_name_passes( &file->passes, all, sizeof all );
    if ( pass == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%.400s: has no layer %.100s; it has %s", file->path, picture->layer, all );
    RfResult result = rf_read_passes( file->path, pass, 1, window, &values, &stride, error );
    if ( result == RF_OK )
        result = rf_create_image( window->width, window->height, image, error );
    if ( result == RF_OK )
        rf_draw_pass( pass, picture->range, values, (size_t)stride, (size_t)image->width * (size_t)image->height, image->rgb );
    free( values );
    return result;
}

static RfResult add_range( PngPicture* picture, const PngFile* file, bool is_first, RfError* error )
{
    const RfFilePass* pass = rf_find_pass( &file->passes, picture->layer );
    float* values;
    int stride;
    RfExrWindow window;
    if ( pass == NULL )
        return RF_OK; // the error comes with its frame
    RF_TRY( rf_read_passes( file->path, pass, 1, &window, &values, &stride, error ) );
    RfLookRange range = rf_pass_range( pass, values, (size_t)stride, (size_t)window.width * (size_t)window.height );
    free( values );
    picture->range.low = is_first ? range.low : fminf( picture->range.low, range.low );
    picture->range.high = is_first ? range.high : fmaxf( picture->range.high, range.high );
    return RF_OK;
}

static RfResult find_ranges( PngPicture* picture, const char* const* paths, int count, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        PngFile file;
        result = open_file( paths[i], &file, error );
        if ( result == RF_OK )
            result = add_range( picture, &file, i == 0, error );
        close_file( &file );
    }
    return result;
}

static RfResult find_kind( PngPicture* picture, const PngFile* file, RfError* error )
{
    const RfFilePass* pass = picture->layer != NULL ? rf_find_pass( &file->passes, picture->layer ) : NULL;
    bool alone = picture->matte == NULL && picture->mix == NULL;
    picture->kind = picture->mix != NULL     ? RF_PNG_MIX
                    : picture->matte != NULL ? RF_PNG_MATTE
                    : picture->layer == NULL ? RF_PNG_COLOUR
                    : pass != NULL           ? RF_PNG_PASS
                                             : RF_PNG_VALUES;
    bool bright = picture->kind == RF_PNG_PASS && ( pass->look == RF_LOOK_LIGHT || pass->look == RF_LOOK_DEVIATION );
    picture->takes_exposure = bright || ( alone && picture->kind != RF_PNG_PASS ) || picture->mix != NULL;
    picture->takes_view = picture->takes_exposure && ( pass == NULL || pass->is_light ) && picture->kind != RF_PNG_VALUES;
    if ( picture->mix == NULL )
        return picture->matte != NULL ? find_matte( picture, file, error ) : RF_OK;
    if ( picture->layer != NULL || picture->matte != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--mix: shows the light groups: leave out --%s",
                        picture->layer != NULL ? "layer" : "matte" );
    RF_TRY( parse_factors( picture, error ) );
    return check_groups( picture, file, error );
}

// Finds in the first of `count` files what is shown, and the range of its values in all of them. Fails with RF_ERROR_USAGE for what
// does not go together, with RF_ERROR_FORMAT for what the file does not hold.
static RfResult find_png_picture( PngPicture* picture, const char* const* paths, int count, RfError* error )
{
    PngFile file;
    RfResult result = open_file( paths[0], &file, error );
    if ( result == RF_OK )
        result = find_kind( picture, &file, error );
    close_file( &file );
    return result == RF_OK && picture->kind == RF_PNG_PASS ? find_ranges( picture, paths, count, error ) : result;
}

// The channel A of a file; NULL where it has none of the size of its colour.
static float* read_alpha( const PngFile* file, const RfImage* image )
{
    const RfFilePass* pass = rf_find_pass( &file->passes, "alpha" );
    RfExrWindow window;
    float* alpha = NULL;
    int stride;
    if ( pass == NULL || rf_read_passes( file->path, pass, 1, &window, &alpha, &stride, NULL ) != RF_OK )
        return NULL;
    if ( window.width == image->width && window.height == image->height )
        return alpha;
    free( alpha );
    return NULL;
}

static RfResult read_picture( const PngPicture* picture, const PngFile* file, RfImage* image, RfExrWindow* window,
                              RfError* error )
{
    switch ( picture->kind )
    {
        case RF_PNG_COLOUR: return rf_read_exr_layer( file->path, NULL, image, window, error );
        case RF_PNG_PASS: return draw_pass( picture, file, image, window, error );
        case RF_PNG_VALUES: return rf_read_pass_image( file->path, picture->layer, image, window, &( size_t ){ 0 }, error );
        case RF_PNG_MIX: return mix_groups( picture, file, image, window, error );
        case RF_PNG_MATTE: return draw_matte( picture, file, image, window, error );
    }
    return RF_OK;
}

// Values of pixels, `channels` each, in another window: 0 where the first has none. NULL: no memory.
static float* move_window( const float* from, int channels, const RfExrWindow* window, const RfExrWindow* to )
{
    float* moved = calloc( (size_t)to->width * (size_t)to->height * (size_t)channels, sizeof *moved );
    int64_t dx = (int64_t)window->x - to->x, dy = (int64_t)window->y - to->y; // where the first begins in the other
    int64_t left = dx > 0 ? dx : 0, right = dx + window->width < to->width ? dx + window->width : to->width;
    for ( int y = 0; y < to->height && moved != NULL && left < right; ++y )
    {
        if ( y < dy || y - dy >= window->height )
            continue;
        memcpy( moved + (size_t)channels * ( (size_t)y * (size_t)to->width + (size_t)left ),
                from + (size_t)channels * ( (size_t)( y - dy ) * (size_t)window->width + (size_t)( left - dx ) ),
                (size_t)channels * (size_t)( right - left ) * sizeof *moved );
    }
    return moved;
}

// Crops to the display window, or fills it with black.
static RfResult show_display_window( const PngFile* file, const RfExrWindow* window, RfImage* image, float** alpha,
                                     RfError* error )
{
    const RfExrHeader* header = &file->header;
    RfExrWindow display = { header->display_x, header->display_y, header->display_width, header->display_height };
    if ( memcmp( &display, window, sizeof display ) == 0 )
        return RF_OK;
    if ( (double)display.width * display.height > MOST_PIXELS )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: its display window has %dx%d pixels: --window data shows the others",
                        file->path, display.width, display.height );
    float* rgb = move_window( image->rgb, 3, window, &display );
    float* covered = *alpha != NULL && rgb != NULL ? move_window( *alpha, 1, window, &display ) : NULL;
    if ( rgb == NULL || ( *alpha != NULL && covered == NULL ) )
    {
        free( rgb );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its display window of %dx%d pixels", file->path,
                        display.width, display.height );
    }
    rf_destroy_image( image );
    free( *alpha );
    *image = ( RfImage ){ display.width, display.height, rgb };
    *alpha = covered;
    return RF_OK;
}

static void show( const void* view, float* rgb, int count ) { rf_apply_view( view, rgb, count ); }

static RfResult write_png_picture( const PngPicture* picture, const char* from, const char* to, RfError* error )
{
    PngFile file;
    RfImage image = { 0 };
    RfExrWindow window = { 0 };
    RfResult result = open_file( from, &file, error );
    if ( result == RF_OK )
        result = read_picture( picture, &file, &image, &window, error );
    bool has_alpha = result == RF_OK && ( picture->kind == RF_PNG_COLOUR || picture->kind == RF_PNG_MIX );
    float* alpha = has_alpha ? read_alpha( &file, &image ) : NULL;
    if ( result == RF_OK && !picture->data_window )
        result = show_display_window( &file, &window, &image, &alpha, error );
    if ( result == RF_OK && picture->view != NULL )
        result = rf_write_png_shown( to, &image, alpha, show, picture->view, error );
    else if ( result == RF_OK )
        result = rf_write_png_alpha( to, &image, alpha, picture->takes_exposure ? (float)picture->exposure : 0.0f, error );
    free( alpha );
    rf_destroy_image( &image );
    close_file( &file );
    return result;
}

#define COMMAND "png"

static RfViewOptions s_view;
static PngPicture s_picture;
static const char* s_frames;
static int s_window;
static bool s_quiet;
static const char* const s_windows[] = { "display", "data", NULL };
static const char* const s_files[] = { "IN", "OUT" };
static const RfOption s_options[] = {
    RF_REAL_OPTION( "exposure", &s_view.exposure, -32, 32, "E|auto",
                    "exposure in stops: each doubles the brightness; auto: middle grey, for all frames alike",
                    .given = &s_view.exposure_given, .keyword = "auto", .keyword_value = RF_EXPOSURE_AUTO,
                    .default_text = "the files', else 0" ),
    RF_VIEW_OPTIONS( s_view, RF_HEADING_BASIC ),
    RF_TEXT_OPTION(
        "layer", &s_picture.layer, "NAME",
        "a pass, such as depth, light_key or CryptoObject, drawn so that it can be seen; or a part, a channel, or three "
        "channels X,Y,Z as they are",
        .default_text = "colour" ),
    RF_TEXT_OPTION( "matte", &s_picture.matte, "NAME",
                    "the pixels that an object, material or asset of this name covers, by the Cryptomatte of the files" ),
    RF_TEXT_OPTION( "mix", &s_picture.mix, "GROUP=F[,...]",
                    "the sum of the light groups, these with other factors: key=0.3,fill=2; the others with 1" ),
    RF_CHOICE_OPTION( "window", &s_window, s_windows, "the picture alone, or all pixels of the files, with overscan" ),
    RF_TEXT_OPTION( "frames", &s_frames, "[@]A-B[xSTEP][,...]", "convert only these frames of a sequence",
                    .default_text = "all" ),
    RF_FLAG_OPTION( "quiet", &s_quiet, "no progress, no summary" ),
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary =
                                            "Writes EXR files as 8-bit PNG, by the view that they name or the sRGB curve, "
                                            "and with their alpha if they have one. IN is a file, a sequence named with "
                                            "####, or its folder; OUT a file, a name with #### for a sequence, or a folder, "
                                            "which is made where it is missing.",
                                        RF_TABLE_ROWS( s_files, s_options ),
                                        .writes_last = ".png" };

// What is read and written.
typedef struct Job
{
    const char* files[2];
    RfSequenceInput from;
    char to[RF_FILE_NAME_SIZE]; // a pattern or a file
    RfView* view;               // NULL: what is shown is no light
} Job;

// Is this the folder of the files? Of a sequence, what is not called .png is.
static bool is_folder_name( const char* to, const RfSequenceInput* from )
{
    const char* dot = strrchr( to, '.' );
    return rf_is_folder( to ) || to[strlen( to ) - 1] == '/' ||
           ( from->is_sequence && !rf_is_sequence( to ) && ( dot == NULL || strchr( dot, '/' ) != NULL ) );
}

// In a folder the names are those of what is read.
static RfResult name_output( const char* to, Job* job, RfError* error )
{
    const char *from = job->from.pattern, *slash = strrchr( from, '/' ), *base = slash != NULL ? slash + 1 : from;
    const char* dot = strrchr( base, '.' );
    int length = dot != NULL ? (int)( dot - base ) : (int)strlen( base ), used;
    const char* end = to + strlen( to ) - 1;
    if ( is_folder_name( to, &job->from ) )
        used = snprintf( job->to, sizeof job->to, "%s%s%.*s.png", to, *end == '/' ? "" : "/", length, base );
    else
        used = snprintf( job->to, sizeof job->to, "%s", to );
    if ( used >= (int)sizeof job->to )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", to );
    if ( job->from.count > 1 && !rf_is_sequence( job->to ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has no #### for the number, but there are %d frames", to, job->from.count );
    return RF_OK;
}

static RfResult convert_frame( const Job* job, int frame, RfError* error )
{
    char from[RF_FILE_NAME_SIZE], to[RF_FILE_NAME_SIZE];
    RF_TRY( rf_sequence_input_name( &job->from, frame, from, error ) );
    RF_TRY( rf_sequence_name( job->to, frame, to, sizeof to, error ) );
    return write_png_picture( &s_picture, from, to, error );
}

// The first frame, the one in the middle and the last stand for all.
typedef struct Samples
{
    char names[3][RF_FILE_NAME_SIZE];
    const char* paths[3];
    int count;
} Samples;

static RfResult choose_samples( const RfSequenceInput* from, Samples* samples, RfError* error )
{
    int all = from->is_sequence ? from->count : 1, chosen[3] = { 0, all / 2, all - 1 };
    RfResult result = RF_OK;
    samples->count = all < 3 ? all : 3;
    for ( int i = 0; i < samples->count && result == RF_OK; ++i )
    {
        samples->paths[i] = samples->names[i];
        result = rf_sequence_input_name( from, from->is_sequence ? from->frames[chosen[i]] : 0, samples->names[i], error );
    }
    return result;
}

// As the first frame has it; for light, or where one is asked for.
static RfResult open_view( Job* job, const Samples* samples, RfError* error )
{
    RfLog log = rf_stderr_log( COMMAND );
    RfViewText chosen;
    bool automatic = s_view.exposure_given && s_view.exposure == (double)RF_EXPOSURE_AUTO;
    RfResult result = RF_OK;
    if ( !s_picture.takes_exposure && ( s_view.exposure_given || s_view.view != NULL || s_view.look != NULL ) )
        rf_warn( &log, "%s is not a colour: exposure and view do not apply",
                 s_picture.matte != NULL ? "a matte" : s_picture.layer );
    if ( !s_picture.takes_exposure )
        return RF_OK;
    if ( automatic )
        result = rf_find_exposure( samples->paths, samples->count, &s_view.exposure, error );
    s_picture.exposure = s_view.exposure;
    if ( result == RF_OK && ( s_picture.takes_view || s_view.view != NULL ) )
        result = rf_open_chosen_view( &s_view, samples->paths[0], &log, &job->view, &chosen, error );
    s_picture.view = job->view;
    return result;
}

static RfResult open_picture( Job* job, RfError* error )
{
    Samples samples;
    s_picture.data_window = s_window == 1;
    RF_TRY( choose_samples( &job->from, &samples, error ) );
    RF_TRY( find_png_picture( &s_picture, samples.paths, samples.count, error ) );
    return open_view( job, &samples, error );
}

static RfResult run( void* user, RfError* error )
{
    Job* job = user;
    const RfSequenceInput* from = &job->from;
    RfLog log = rf_stderr_log( COMMAND );
    RfResult result = rf_find_sequence_input( job->files[0], s_frames, &job->from, error );
    if ( result == RF_OK )
        result = name_output( job->files[1], job, error );
    if ( result == RF_OK )
        result = open_picture( job, error );
    if ( result == RF_OK )
        result = rf_prepare_output_folder( job->to, error );
    if ( result == RF_OK && !from->is_sequence )
        return write_png_picture( &s_picture, from->pattern, job->to, error );
    if ( result == RF_OK && s_frames == NULL )
        result = rf_warn_of_missing( from, &log, error );
    for ( int i = 0; i < from->count && result == RF_OK; ++i )
    {
        result = convert_frame( job, from->frames[i], error );
        rf_show_frame_count( s_quiet, i + 1, from->count );
    }
    if ( result != RF_OK || s_quiet )
        return result;
    rf_print( "%d frame%s in %s\n", from->count, from->count == 1 ? "" : "s", job->to );
    return rf_flush_output( error );
}

int rf_command_png( int argc, char** argv )
{
    Job job = { .view = NULL };
    int status = rf_run_command( &s_table, argc, argv, job.files, run, &job );
    rf_close_view( job.view );
    rf_free_sequence_input( &job.from );
    return status;
}
