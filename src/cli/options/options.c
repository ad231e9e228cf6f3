// Parses arguments by a table of options, and prints the help from it.
#include "cli/options/options.h"

#include "base/try.h"
#include "cli/messages.h"
#include "image/atomic_file.h"
#include "image/sequence.h"
#include "scene/scene.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

// Words of Blender, pbrt, Mitsuba, ffmpeg, Embree's tutorials and of Unix. Where a word has
// several meanings, each command takes the first that it has.
static const char* const s_synonyms[][2] = {
    { "samples", "spp" },
    { "samples-per-pixel", "spp" },
    { "resolution", "size" },
    { "dimensions", "size" },
    { "width", "size" },
    { "height", "size" },
    { "quality", "noise" },
    { "error", "noise" },
    { "noise-threshold", "noise" },
    { "seconds", "time" },
    { "seconds", "budget" },
    { "time-limit", "time" },
    { "time", "budget" },
    { "duration", "time" },
    { "framerate", "fps" },
    { "frame-rate", "fps" },
    { "rate", "fps" },
    { "range", "frames" },
    { "start", "frames" },
    { "end", "frames" },
    { "bounces", "max-depth" },
    { "max-bounces", "max-depth" },
    { "depth", "max-depth" },
    { "cores", "threads" },
    { "jobs", "threads" },
    { "cpus", "threads" },
    { "ram", "memory" },
    { "layers", "aov" },
    { "layers", "layer" },
    { "layer", "aov" },
    { "passes", "aov" },
    { "channel", "layer" },
    { "denoise-layers", "aov" },
    { "window", "group" },
    { "block", "tile" },
    { "bucket", "tile" },
    { "force", "overwrite" },
    { "replace", "overwrite" },
    { "continue", "resume" },
    { "silent", "quiet" },
    { "stops", "exposure" },
    { "ev", "exposure" },
    { "brightness", "exposure" },
    { "ground-truth", "reference" },
    { "units", "scale" },
    { "view", "camera" },
    // commands
    { "diff", "compare" },
    { "plan", "tune" },
    { "benchmark", "cost" },
    { "bench", "cost" },
    { "poisson", "reconstruct" },
    { "solve", "reconstruct" },
    { "view", "png" },
    { "export", "png" },
    { "import", "convert" },
    { "html", "report" },
    { "page", "report" },
    { "inspect", "info" },
    { "version", "--version" },
    { "man", "--man" },
    { "manual", "--man" },
};

const char* rf_find_synonym( const char* word, const char* const* words, int count )
{
    for ( size_t i = 0; i < sizeof s_synonyms / sizeof s_synonyms[0]; ++i )
    {
        for ( int k = 0; k < count && strcmp( s_synonyms[i][0], word ) == 0; ++k )
        {
            if ( strcmp( s_synonyms[i][1], words[k] ) == 0 )
                return words[k];
        }
    }
    return NULL;
}

// A whole number from min to max, with nothing before or after it.
static bool parse_whole( const char* text, long long min, long long max, long long* value )
{
    // strtoll skips blanks and takes a plus sign; a number on a command line has neither.
    if ( !isdigit( (unsigned char)text[text[0] == '-'] ) )
        return false;
    char* end;
    errno = 0;
    long long number = strtoll( text, &end, 10 );
    if ( errno != 0 || *end != '\0' || number < min || number > max )
        return false;
    *value = number;
    return true;
}

// A file named on the command line.
typedef struct Named
{
    const char* path;
    const char* option; // NULL: positional
    const char* writes; // the ending required where it is written, "" for any; NULL: it is read
} Named;

static bool is_file( const char* path )
{
    struct stat status;
    return path != NULL && strcmp( path, "-" ) != 0 && ( stat( path, &status ) != 0 || S_ISREG( status.st_mode ) );
}

// The ending of a name, ".exr": a dot, a letter and up to four more letters or digits, which "frame.####" and "tmp.ab3x7q" have not.
static const char* find_ending( const char* path )
{
    const char *dot = strrchr( path, '.' ), *slash = strrchr( path, '/' );
    if ( dot == NULL || dot < slash || !isalpha( (unsigned char)dot[1] ) )
        return NULL;
    size_t length = 1;
    while ( isalnum( (unsigned char)dot[length] ) )
        ++length;
    return dot[length] == '\0' && length <= 6 ? dot : NULL;
}

static RfResult check_ending( const Named* file, RfError* error )
{
    const char* option = file->option;
    if ( file->writes[0] == '\0' || find_ending( file->path ) == NULL || rf_has_extension( file->path, file->writes ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE, "%s%s%s%s: ends as a file of another kind: name it %s", option != NULL ? "--" : "",
                    option != NULL ? option : "", option != NULL ? ": " : "", file->path, file->writes );
}

// Tries to write, before there is work for nothing. A port of --preview is no file.
static RfResult try_file( const Named* file, RfError* error )
{
    struct stat status;
    long long port;
    RfError reason = { 0 };
    bool is_special = stat( file->path, &status ) == 0 && !S_ISREG( status.st_mode ) && !S_ISDIR( status.st_mode );
    if ( strcmp( file->path, "-" ) == 0 || is_special || parse_whole( file->path + ( file->path[0] == ':' ), 0, 65535, &port ) )
        return RF_OK;
    RfResult result = rf_try_output_file( file->path, &reason );
    return result == RF_OK ? RF_OK : rf_fail( error, result, "--%s: %.900s", file->option, reason.text );
}

static RfResult check_pair( const Named* file, const Named* other, RfError* error )
{
    if ( !rf_may_be_same_file( file->path, other->path ) )
        return RF_OK;
    const char* name = file->option != NULL ? file->option : other->option;
    if ( name == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is also the input: choose another name for the output", file->path );
    if ( other->option == NULL || file->option == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: %s: would overwrite %s: choose another name", name, file->path,
                        other->writes != NULL ? "another output" : "an input" );
    return rf_fail( error, RF_ERROR_USAGE, "--%s: %s: is the file of --%s too: choose another name", name, file->path,
                    other->option );
}

static int collect( const RfCommandTable* table, const char* const* files, int file_count, Named* named, int room )
{
    int count = 0;
    for ( int i = 0; i < file_count && count < room; ++i )
        named[count++] = ( Named ){ .path = files[i], .writes = i == file_count - 1 ? table->writes_last : NULL };
    for ( int i = 0; i < table->option_count && count < room; ++i )
    {
        const RfOption* option = table->options + i;
        if ( !option->reads && option->writes == NULL )
            continue;
        named[count++] = ( Named ){ *(const char* const*)option->value, option->name, option->writes };
    }
    return count;
}

// Compares what is written (options with `writes`, and the last file where the table says
// `writes_last`) with all files and options with `reads`. Fails with RF_ERROR_USAGE, naming
// the option. "-" and devices are not checked.
static RfResult check_written_files( const RfCommandTable* table, const char* const* files, int file_count, RfError* error )
{
    Named named[64];
    int count = collect( table, files, file_count, named, 64 );
    for ( int i = 0; i < count; ++i )
    {
        if ( named[i].writes == NULL || !is_file( named[i].path ) )
            continue;
        RfResult result = check_ending( named + i, error );
        for ( int k = 0; k < count && result == RF_OK; ++k )
        {
            if ( k != i && is_file( named[k].path ) )
                result = check_pair( named + i, named + k, error );
        }
        if ( result != RF_OK )
            return result;
    }
    for ( int i = 0; i < count; ++i )
    {
        bool is_tried = named[i].option != NULL && named[i].path != NULL && named[i].writes != NULL && named[i].writes[0] != '\0';
        RF_TRY( is_tried ? try_file( named + i, error ) : RF_OK );
    }
    return RF_OK;
}

static bool parse_unsigned( const RfOption* option, const char* text, void* value )
{
    (void)option;
    if ( !isdigit( (unsigned char)text[0] ) )
        return false;
    char* end;
    errno = 0;
    unsigned long long number = strtoull( text, &end, 10 );
    if ( errno != 0 || *end != '\0' )
        return false;
    *(uint64_t*)value = number;
    return true;
}

// A decimal number at the start of `text`: no hexadecimal, no "inf" or "nan".
static bool parse_decimal( const char* text, double* value, const char** rest )
{
    size_t length = strspn( text, "+-0123456789.eE" );
    if ( length == 0 || length > 60 || isspace( (unsigned char)text[0] ) )
        return false;
    char copy[64];
    memcpy( copy, text, length );
    copy[length] = '\0';
    char* end;
    *value = strtod( copy, &end );
    *rest = text + ( end - copy );
    return end != copy && isfinite( *value );
}

static bool parse_real( const RfOption* option, const char* text, void* value )
{
    const char* rest;
    double number;
    bool keyword = option->keyword != NULL && strcmp( text, option->keyword ) == 0;
    if ( keyword || ( option->negated != NULL && strcmp( text, option->negated ) == 0 ) )
    {
        *(double*)value = keyword ? option->keyword_value : 0.0;
        return true;
    }
    if ( !parse_decimal( text, &number, &rest ) || *rest != '\0' || number < option->min || number > option->max )
        return false;
    *(double*)value = number;
    return true;
}

bool rf_parse_error_goal( const char* text, bool is_flicker, double* value, const char** rest )
{
    if ( !parse_decimal( text, value, rest ) )
        return false;
    if ( **rest != '%' )
        return true;
    *rest += 1;
    bool positive = *value >= 0.0;
    *value = is_flicker ? *value / 100.0 : rf_relmse_of_noise( *value );
    return positive;
}

static bool parse_error_goal( const RfOption* option, const char* text, void* value )
{
    const char* rest;
    double number;
    if ( !rf_parse_error_goal( text, option->type == RF_OPTION_FLICKER, &number, &rest ) || *rest != '\0' ||
         number < option->min || number > option->max )
        return false;
    *(double*)value = number;
    return true;
}

// Seconds, or hours, minutes and seconds in this order, each with its letter.
static bool parse_time( const RfOption* option, const char* text, void* value )
{
    static const struct
    {
        char letter;
        double seconds;
    } units[] = { { 'h', 3600.0 }, { 'm', 60.0 }, { 's', 1.0 } };
    double number, sum = 0.0;
    const char* rest = text;
    if ( parse_real( option, text, value ) )
        return true;
    for ( size_t i = 0; i < sizeof units / sizeof units[0] && *rest != '\0'; ++i )
    {
        const char* next;
        if ( !isdigit( (unsigned char)*rest ) || !parse_decimal( rest, &number, &next ) )
            return false;
        if ( *next != units[i].letter )
            continue;
        sum += number * units[i].seconds;
        rest = next + 1;
    }
    if ( rest == text || *rest != '\0' || sum < option->min || sum > option->max )
        return false;
    *(double*)value = sum;
    return true;
}

static bool parse_memory( const RfOption* option, const char* text, void* value )
{
    const char* rest;
    double number;
    if ( !isdigit( (unsigned char)text[0] ) || !parse_decimal( text, &number, &rest ) )
        return false;
    static const char units[] = "KMGT";
    if ( *rest != '\0' )
    {
        const char* unit = strchr( units, toupper( (unsigned char)*rest ) );
        if ( unit == NULL || rest[1] != '\0' )
            return false;
        number = ldexp( number, 10 * (int)( unit - units + 1 ) );
    }
    // 2^62 bytes are more than any machine has, and far from overflow.
    if ( number < option->min || number > 0x1p62 )
        return false;
    *(size_t*)value = (size_t)number;
    return true;
}

// Two whole numbers with a separator between them.
static bool parse_pair( const char* text, char separator, long long min, long long max, int* first, int* second )
{
    const char* middle = strchr( text, separator );
    if ( middle == NULL || middle - text > 20 )
        return false;
    char head[24];
    memcpy( head, text, (size_t)( middle - text ) );
    head[middle - text] = '\0';
    long long a, b;
    if ( !parse_whole( head, min, max, &a ) || !parse_whole( middle + 1, min, max, &b ) )
        return false;
    *first = (int)a;
    *second = (int)b;
    return true;
}

// Names of sizes, all 16:9.
static bool parse_size( const RfOption* option, const char* text, void* value )
{
    RfSize* size = value;
    static const struct
    {
        const char* name;
        RfSize size;
    } names[] = {
        { "360p", { 640, 360 } },    { "540p", { 960, 540 } },    { "720p", { 1280, 720 } }, { "1080p", { 1920, 1080 } },
        { "1440p", { 2560, 1440 } }, { "2160p", { 3840, 2160 } }, { "4k", { 3840, 2160 } },  { "4K", { 3840, 2160 } },
    };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        if ( strcmp( text, names[i].name ) == 0 && names[i].size.width <= option->max )
        {
            *size = names[i].size;
            return true;
        }
    }
    return parse_pair( text, 'x', (long long)option->min, (long long)option->max, &size->width, &size->height );
}

static bool parse_int( const RfOption* option, const char* text, void* value )
{
    if ( option->keyword != NULL && strcmp( text, option->keyword ) == 0 )
    {
        *(int*)value = option->keyword_value;
        return true;
    }
    long long whole;
    if ( !parse_whole( text, (long long)option->min, (long long)option->max, &whole ) )
        return false;
    *(int*)value = (int)whole;
    return true;
}

static bool parse_choice( const RfOption* option, const char* text, void* value )
{
    for ( int i = 0; option->choices[i] != NULL; ++i )
    {
        if ( strcmp( text, option->choices[i] ) == 0 )
        {
            *(int*)value = i;
            return true;
        }
    }
    return false;
}

static bool parse_fps( const RfOption* option, const char* text, void* value )
{
    (void)option;
    return rf_parse_fps( text, value );
}

static bool parse_text( const RfOption* option, const char* text, void* value )
{
    (void)option;
    *(const char**)value = text;
    return text[0] != '\0';
}

static bool parse_nothing( const RfOption* option, const char* text, void* value )
{
    (void)option, (void)text, (void)value;
    return false;
}

// Values of a type, and what is wanted on a command line and as JSON, by the option's min and max.
static const struct
{
    size_t size;
    bool ( *parse )( const RfOption* option, const char* text, void* value );
    const char *wanted, *json;
} s_types[] = {
    [RF_OPTION_INT] = { sizeof( int ), parse_int, "a whole number from %.0f to %.0f", "a whole number from %.0f to %.0f" },
    [RF_OPTION_UINT64] = { sizeof( uint64_t ), parse_unsigned, "a whole number from 0 to 18446744073709551615",
                           "a whole number from 0 to 9223372036854775807" },
    [RF_OPTION_REAL] = { sizeof( double ), parse_real, "a number from %g to %g", "a number from %g to %g" },
    [RF_OPTION_NOISE] = { sizeof( double ), parse_error_goal,
                          "a relMSE from %g to %g, or the noise of a channel in percent, such as 5%%",
                          "a relMSE from %g to %g, or the noise of a channel in percent, such as \"5%%\"" },
    [RF_OPTION_FLICKER] = { sizeof( double ), parse_error_goal, "a relative F1 from %g to %g, or in percent, such as 2%%",
                            "a relative F1 from %g to %g, or in percent, such as \"2%%\"" },
    [RF_OPTION_TIME] = { sizeof( double ), parse_time, "seconds from %g to %g, or a time such as 20s, 5m or 1h30m",
                         "a number from %g to %g" },
    [RF_OPTION_SIZE] = { sizeof( RfSize ), parse_size,
                         "WIDTHxHEIGHT, such as 960x540, each from %.0f to %.0f, or 720p, 1080p, 1440p, 2160p or 4k",
                         "an array of width and height, such as [960, 540], each a whole number from %.0f to %.0f" },
    [RF_OPTION_MEMORY] = { sizeof( size_t ), parse_memory, "a size such as 512M, 4G or 1.5G, at least %.0f bytes",
                           "a string such as \"512M\" or \"4G\", at least %.0f bytes" },
    [RF_OPTION_FPS] = { sizeof( RfFps ), parse_fps, "frames per second, such as 24, 29.97 or 30000/1001",
                        "a whole number from 1 to 1000000, 29.97 and the like, or a string such as \"24000/1001\"" },
    [RF_OPTION_CHOICE] = { sizeof( int ), parse_choice, "", "one of " },
    [RF_OPTION_STRING] = { sizeof( const char* ), parse_text, "a value that is not empty", "a string that is not empty" },
    [RF_OPTION_BOOL] = { sizeof( bool ), parse_nothing, "no value", "true or false" },
};

static bool is_choice( const RfOption* option, const char* text )
{
    int unused;
    return parse_choice( option, text, &unused );
}

void rf_describe_wanted( const RfOption* option, bool is_json, char* words, size_t size )
{
    bool is_real = option->type == RF_OPTION_REAL;
    const char *quote = is_json ? "\"" : "", *wanted = is_json ? s_types[option->type].json : s_types[option->type].wanted;
    if ( is_json && option->bare != NULL )
        rf_append( words, size, "true, false, or " );
    if ( is_real && option->negated != NULL )
        rf_append( words, size, "%s%s%s, ", quote, option->negated, quote );
    if ( is_real && option->keyword != NULL )
        rf_append( words, size, "%s%s%s or ", quote, option->keyword, quote );
    rf_append( words, size, wanted, option->min, option->max );
    if ( option->type == RF_OPTION_INT && option->keyword != NULL )
        rf_append( words, size, " or %s%s%s", quote, option->keyword, quote );
    if ( option->type == RF_OPTION_CHOICE )
        rf_append_words( words, size, option->choices, ", ", is_json ? ", " : " or " );
}

RfResult rf_parse_option_value( const RfOption* option, const char* text, RfError* error )
{
    char wanted[256] = "";
    if ( s_types[option->type].parse( option, text, option->value ) )
        return RF_OK;
    rf_describe_wanted( option, false, wanted, sizeof wanted );
    return rf_fail( error, RF_ERROR_USAGE, "--%s: expected %s, got '%s'", option->name, wanted, text );
}

#define MAX_OPTIONS 64

// Any value of an option.
typedef union Value
{
    int whole;
    uint64_t seed;
    double real;
    RfSize size;
    size_t bytes;
    RfFps fps;
    const char* text;
    bool flag;
} Value;

// The state of one parse.
typedef struct Parse
{
    const RfCommandTable* table;
    int argc;
    char** argv;
    int next; // argument to be read
    const char** files;
    int file_count;
    Value defaults[MAX_OPTIONS];
} Parse;

static RfResult fail_unknown( const RfCommandTable* table, const char* argument, const char* name, RfError* error )
{
    const char* names[MAX_OPTIONS + 1];
    for ( int i = 0; i < table->option_count; ++i )
        names[i] = table->options[i].name;
    names[table->option_count] = "help";
    const char* nearest = rf_find_synonym( name, names, table->option_count );
    if ( nearest == NULL )
        nearest = rf_nearest_word( name, names, table->option_count + 1 );
    int length = (int)strcspn( argument, "=" );
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%.*s: no such option, did you mean --%s?", length, argument, nearest );
    return rf_fail( error, RF_ERROR_USAGE, "%.*s: no such option, see reframe %s --help", length, argument, table->command );
}

static bool has_negation( const RfOption* option ) { return option->type == RF_OPTION_BOOL || option->negated != NULL; }

// Index of the option with this name (length characters), or −1. Sets *negated for --no-name.
static int find_long( const RfCommandTable* table, const char* name, size_t length, bool* negated )
{
    for ( int i = 0; i < table->option_count; ++i )
    {
        const char* known = table->options[i].name;
        *negated = false;
        if ( strlen( known ) == length && strncmp( known, name, length ) == 0 )
            return i;
        *negated = true;
        if ( has_negation( table->options + i ) && length == strlen( known ) + 3 && strncmp( name, "no-", 3 ) == 0 &&
             strncmp( known, name + 3, length - 3 ) == 0 )
            return i;
    }
    *negated = false;
    return -1;
}

static int find_letter( const RfCommandTable* table, char letter )
{
    for ( int i = 0; i < table->option_count; ++i )
    {
        if ( table->options[i].letter == letter )
            return i;
    }
    return -1;
}

// "-5--1" and "-1.5" are values, "-" is standard output; "-o" and "--spp" are
// the next option, so the value was left out.
static bool looks_like_option( const char* text )
{
    return text[0] == '-' && ( isalpha( (unsigned char)text[1] ) || text[1] == '-' );
}

static RfResult fail_value( const RfOption* option, bool negated, const char* value, RfError* error )
{
    return rf_fail( error, RF_ERROR_USAGE, "--%s%s: takes no value, got '%s'", negated ? "no-" : "", option->name, value );
}

// A value that may be left out: the next argument counts as one only if it is one of the choices.
static const char* optional_value( Parse* parse, const RfOption* option )
{
    if ( parse->next < parse->argc && is_choice( option, parse->argv[parse->next] ) )
        return parse->argv[parse->next++];
    return option->bare;
}

// Stores option `index`; `value` is what stood after '=', or NULL.
static RfResult take_option( Parse* parse, int index, bool negated, const char* value, RfError* error )
{
    const RfOption* option = parse->table->options + index;
    if ( option->given != NULL )
        *option->given = true;
    if ( option->type == RF_OPTION_BOOL )
    {
        if ( value != NULL )
            return fail_value( option, negated, value, error );
        *(bool*)option->value = !negated;
        return RF_OK;
    }
    if ( negated && value != NULL )
        return fail_value( option, negated, value, error );
    if ( negated )
        value = option->negated;
    if ( value == NULL && option->bare != NULL )
        value = optional_value( parse, option );
    if ( value == NULL )
    {
        if ( parse->next == parse->argc || looks_like_option( parse->argv[parse->next] ) )
            return rf_fail( error, RF_ERROR_USAGE, "--%s: its value is missing", option->name );
        value = parse->argv[parse->next++];
    }
    return rf_parse_option_value( option, value, error );
}

static RfResult take_argument( Parse* parse, const char* argument, RfError* error )
{
    const RfCommandTable* table = parse->table;
    bool negated = false;
    if ( strncmp( argument, "--", 2 ) == 0 )
    {
        const char* name = argument + 2;
        size_t length = strcspn( name, "=" );
        int index = find_long( table, name, length, &negated );
        if ( index >= 0 )
            return take_option( parse, index, negated, name[length] == '=' ? name + length + 1 : NULL, error );
        char copy[64];
        snprintf( copy, sizeof copy, "%.*s", (int)( length < 60 ? length : 60 ), name );
        return fail_unknown( table, argument, copy, error );
    }
    int index = argument[2] == '\0' ? find_letter( table, argument[1] ) : -1;
    if ( index < 0 )
        return fail_unknown( table, argument, argument + 1, error );
    return take_option( parse, index, false, NULL, error );
}

static RfResult take_file( Parse* parse, const char* argument, RfError* error )
{
    const RfCommandTable* table = parse->table;
    int last = table->file_count - 1, most = table->file_max > 0 ? table->file_max : table->file_count;
    if ( parse->file_count == most )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' is one file too many, see reframe %s --help", argument, table->command );
    if ( argument[0] == '\0' )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is empty",
                        table->files[parse->file_count < last ? parse->file_count : last] );
    parse->files[parse->file_count++] = argument;
    return RF_OK;
}

// The help states defaults, whatever stands before --help.
static void keep_defaults( Parse* parse )
{
    for ( int i = 0; i < parse->table->option_count; ++i )
        memcpy( parse->defaults + i, parse->table->options[i].value, s_types[parse->table->options[i].type].size );
}

static void restore_defaults( const Parse* parse )
{
    for ( int i = 0; i < parse->table->option_count; ++i )
        memcpy( parse->table->options[i].value, parse->defaults + i, s_types[parse->table->options[i].type].size );
}

RfResult rf_parse_options( const RfCommandTable* table, int argc, char** argv, const char** files, bool* help, RfError* error )
{
    Parse parse = { .table = table, .argc = argc, .argv = argv, .next = 1, .files = files };
    *help = false;
    if ( table->option_count > MAX_OPTIONS )
        return rf_fail( error, RF_ERROR_USAGE, "%s has too many options", table->command );
    keep_defaults( &parse );
    bool ended = false;
    while ( parse.next < argc )
    {
        const char* argument = argv[parse.next++];
        RfResult result = RF_OK;
        if ( !ended && strcmp( argument, "--" ) == 0 )
            ended = true;
        else if ( !ended && ( strcmp( argument, "--help" ) == 0 || strcmp( argument, "-h" ) == 0 ) )
        {
            *help = true;
            restore_defaults( &parse );
            return RF_OK;
        }
        else if ( !ended && argument[0] == '-' && argument[1] != '\0' )
            result = take_argument( &parse, argument, error );
        else
            result = take_file( &parse, argument, error );
        if ( result != RF_OK )
            return result;
    }
    if ( parse.file_count < table->file_count )
        return rf_fail( error, RF_ERROR_USAGE, "%s is missing, see reframe %s --help", table->files[parse.file_count],
                        table->command );
    if ( table->file_max > 0 )
        *table->file_total = parse.file_count;
    return check_written_files( table, files, parse.file_count, error );
}
