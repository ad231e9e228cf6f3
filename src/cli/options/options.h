// A declarative table of a command's options, from which arguments are parsed and the help is printed.
//
// `--name value` and `--name=value` in any order, mixed with files; booleans are `--name` and `--no-name`, and some choices have these
// forms too; `--` ends the options. Of an option that is given twice, the last holds, as a whole where it is a list. What is unknown, of
// the wrong type, out of range, missing or too much is one error line, RF_ERROR_USAGE, that starts with the option
// ("--spp: expected a whole number from 1 to 1048576, got '0'").
#ifndef REFRAME_CLI_OPTIONS_OPTIONS_H
#define REFRAME_CLI_OPTIONS_OPTIONS_H

#include "reframe/error.h"
#include "reframe/types.h"
#include "base/words.h"

#include <stdio.h>

typedef enum RfOptionType
{
    RF_OPTION_INT,     // int, from min to max
    RF_OPTION_UINT64,  // uint64_t, any
    RF_OPTION_REAL,    // double, from min to max, finite
    RF_OPTION_NOISE,   // double, relMSE, from min to max, or the relative RMS error of a channel in percent: "0.01" or "5.8%"
    RF_OPTION_FLICKER, // double, relative F1, from min to max, or in percent: "0.02" or "2%"
    RF_OPTION_TIME,    // double, seconds, from min to max: "20", "20s", "5m", "1h30m"
    RF_OPTION_SIZE,    // RfSize, "960x540", each from min to max, or "1080p"
    RF_OPTION_MEMORY,  // size_t, bytes, "512M", "4G", "1.5G", from min on (a plain number is bytes)
    RF_OPTION_FPS,     // RfFps, "24", "24000/1001" or "23.976"
    RF_OPTION_CHOICE,  // int, index into choices
    RF_OPTION_STRING,  // const char*, points into argv; may not be empty
    RF_OPTION_BOOL,    // bool
} RfOptionType;

typedef struct RfSize
{
    int width, height;
} RfSize;

// What an option is about: the help has a heading for each where a command has many options.
typedef enum RfHeading
{
    RF_HEADING_BASIC,
    RF_HEADING_QUALITY,
    RF_HEADING_MEASUREMENT,
    RF_HEADING_PASSES,
    RF_HEADING_OUTPUT,
    RF_HEADING_PERFORMANCE,
    RF_HEADING_RESEARCH,
    RF_HEADING_COUNT
} RfHeading;

typedef struct RfOption
{
    const char* name; // without dashes: "spp"
    char letter;      // 'o' for -o, or 0
    RfOptionType type;
    void* value;         // where it goes; holds the default before parsing
    double min, max;     // INT, REAL, SIZE, MEMORY (min only)
    const char* keyword; // INT, REAL: a word that stands for keyword_value, such as "auto"; or NULL
    int keyword_value;
    const char* const* choices; // CHOICE: NULL-terminated
    const char* bare;           // CHOICE: the one that `--name` without a value stands for; NULL: it wants a value
    const char* negated;        // CHOICE: the one that `--no-name` stands for; NULL: there is no such form. REAL: a word for 0
    const char* meta;           // the value's name in the help: "N|auto"; CHOICE and BOOL have theirs
    const char* default_text;   // in the help instead of the value's default, for which "%s" may stand in it; NULL: that value
    const char* help;           // one line
    bool* given;                // set where the option was given; or NULL
    bool in_file;               // a scene file may give it too (rf_read_render_defaults)
    bool reads;                 // STRING: it names a file, or may, that is read
    const char* writes;         // STRING: it names a file that is written, with this ending (".json"), tried before the command
                                // runs; "": the command tries it, and checks its ending; NULL: none
    RfHeading heading;
} RfOption;

// Rows of a table, by the type of the value, whose pointer the compiler checks. `what` is the value's name in the help. The last
// arguments are the help and, behind it, what else there is to say: .default_text = "all", .heading = RF_HEADING_OUTPUT.
#define RF_OPTION_ROW( option, kind, pointer, to, ... )                                                                          \
    {                                                                                                                            \
        .name = ( option ), .type = ( kind ), .value = 1 ? ( to ) : (pointer)0, .help = __VA_ARGS__                              \
    }
#define RF_TEXT_OPTION( option, to, what, ... )                                                                                  \
    RF_OPTION_ROW( option, RF_OPTION_STRING, const char**, to, __VA_ARGS__, .meta = ( what ) )
#define RF_FLAG_OPTION( option, to, ... ) RF_OPTION_ROW( option, RF_OPTION_BOOL, bool*, to, __VA_ARGS__ )
#define RF_ENUM( to ) ( (int*)( to ) ) // whose constants are the indices of its words
#define RF_CHOICE_OPTION( option, to, words, ... )                                                                               \
    RF_OPTION_ROW( option, RF_OPTION_CHOICE, int*, to, __VA_ARGS__, .choices = ( words ) )
#define RF_RANGE_OPTION( option, kind, pointer, to, low, high, what, ... )                                                       \
    RF_OPTION_ROW( option, kind, pointer, to, __VA_ARGS__, .min = ( low ), .max = ( high ), .meta = ( what ) )
#define RF_INT_OPTION( option, to, low, high, what, ... )                                                                        \
    RF_RANGE_OPTION( option, RF_OPTION_INT, int*, to, low, high, what, __VA_ARGS__ )
#define RF_REAL_OPTION( option, to, low, high, what, ... )                                                                       \
    RF_RANGE_OPTION( option, RF_OPTION_REAL, double*, to, low, high, what, __VA_ARGS__ )
#define RF_NOISE_OPTION( option, to, low, high, what, ... )                                                                      \
    RF_RANGE_OPTION( option, RF_OPTION_NOISE, double*, to, low, high, what, __VA_ARGS__ )
#define RF_FLICKER_OPTION( option, to, low, high, what, ... )                                                                    \
    RF_RANGE_OPTION( option, RF_OPTION_FLICKER, double*, to, low, high, what, __VA_ARGS__ )
#define RF_TIME_OPTION( option, to, low, high, what, ... )                                                                       \
    RF_RANGE_OPTION( option, RF_OPTION_TIME, double*, to, low, high, what, __VA_ARGS__ )
#define RF_SIZE_OPTION( option, to, low, high, what, ... )                                                                       \
    RF_RANGE_OPTION( option, RF_OPTION_SIZE, RfSize*, to, low, high, what, __VA_ARGS__ )
#define RF_MEMORY_OPTION( option, to, low, what, ... )                                                                           \
    RF_OPTION_ROW( option, RF_OPTION_MEMORY, size_t*, to, __VA_ARGS__, .min = ( low ), .meta = ( what ) )
#define RF_FPS_OPTION( option, to, what, ... ) RF_OPTION_ROW( option, RF_OPTION_FPS, RfFps*, to, __VA_ARGS__, .meta = ( what ) )
#define RF_UINT64_OPTION( option, to, what, ... )                                                                                \
    RF_OPTION_ROW( option, RF_OPTION_UINT64, uint64_t*, to, __VA_ARGS__, .meta = ( what ) )

// The command line of a command. All its files are required; the last may be repeated
// where file_max allows it.
typedef struct RfCommandTable
{
    const char* command;      // "render"
    const char* summary;      // one line
    const char* const* files; // names of the positional arguments: "SCENE"
    int file_count;
    int file_max;            // of files in all; 0: as many as have names
    int* file_total;         // where file_max > 0: how many were given
    const char* writes_last; // the last file is written, with this ending; NULL: it is read
    const RfOption* options;
    int option_count;
} RfCommandTable;

// The files and options of a table, which are arrays.
#define RF_TABLE_ROWS( file_names, rows )                                                                                        \
    .files = ( file_names ), .file_count = (int)( sizeof( file_names ) / sizeof( file_names )[0] ), .options = ( rows ),         \
    .option_count = (int)( sizeof( rows ) / sizeof( rows )[0] )

// Parses argv[1 …] (argv[0] is the command's name) into the options' values and
// files[0 … file_count), or up to file_max. With `--help` or `-h` anywhere before an error sets
// *help, and nothing else counts. What is written may not be what is read, nor have the ending of another kind of file, and it is
// tried: its folder is made where it is missing (the last part only), RF_ERROR_IO where it cannot be written.
RfResult rf_parse_options( const RfCommandTable* table, int argc, char** argv, const char** files, bool* help, RfError* error );

// Prints the help of a command; the second on standard output. The values must be the defaults.
void rf_print_help( const RfCommandTable* table, FILE* file );
RfResult rf_show_help( const RfCommandTable* table, RfError* error );

// Runs a command: parses its arguments into the options and `files`, and calls `run`, or prints the help. Reports an error, and
// returns the exit status.
int rf_run_command( const RfCommandTable* table, int argc, char** argv, const char** files,
                    RfResult ( *run )( void* user, RfError* error ), void* user );

// Parses one value by the option's type.
RfResult rf_parse_option_value( const RfOption* option, const char* text, RfError* error );

// Appends what an option wants on a command line, or as JSON of a scene file.
void rf_describe_wanted( const RfOption* option, bool is_json, char* words, size_t size );

// A relMSE, or the noise of a channel with %, at the start of `text`; or a relative F1, or that with %. `rest`: what follows.
bool rf_parse_error_goal( const char* text, bool is_flicker, double* value, const char** rest );

// The first of our words for what other programs call a command or an option that is among `words`, or NULL.
const char* rf_find_synonym( const char* word, const char* const* words, int count );

#endif
