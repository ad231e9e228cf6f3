// Writes the manual page (groff) from the option tables that also give the help texts.
#include "cli/help.h"

#include "cli/commands.h"
#include "reframe/aov.h"
#include "reframe/types.h"

int rf_print_commands( const RfCommand* commands, RfHelpPrinter* printer )
{
    char help[] = "--help";
    int status = 0;
    rf_set_help_printer( printer );
    for ( int i = 0; commands[i].name != NULL && status == 0; ++i )
    {
        char name[32];
        snprintf( name, sizeof name, "%s", commands[i].name );
        char* arguments[] = { name, help, NULL };
        status = commands[i].run( 2, arguments );
    }
    rf_set_help_printer( NULL );
    return status;
}

// Escapes what roff would interpret.
static void print_text( const char* text, FILE* file )
{
    if ( *text == '.' || *text == '\'' )
        fputs( "\\&", file );
    for ( const char* c = text; *c != '\0'; ++c )
    {
        if ( *c == '-' )
            fputs( "\\-", file );
        else if ( *c == '\\' )
            fputs( "\\e", file );
        else
            fputc( *c, file );
    }
}

void rf_print_manual_head( FILE* file )
{
    // without a date: equal sources make equal pages
    fprintf( file, ".TH REFRAME 1 \"\" \"reframe %s\" \"User Commands\"\n", rf_version() );
    fputs( ".SH NAME\nreframe \\- renders camera animations with frame reuse\n"
           ".SH SYNOPSIS\n.B reframe\n.I COMMAND\n[\\fIOPTIONS\\fR] \\fIFILES\\fR\n"
           ".SH DESCRIPTION\n"
           "Renders camera paths through glTF scenes to sequences of EXR files. Every light path serves all frames\n"
           "of a group that see its first hit, combined by multiple importance sampling without bias.\n"
           ".PP\n"
           "Options may stand in any order; long ones take \\fB\\-\\-name value\\fR or \\fB\\-\\-name=value\\fR, those in\n"
           "\\fB[no\\-]\\fR have a form with and one without it. In names of frames #### is the frame's number, and\n"
           "%04d the same.\n",
           file );
}

static void print_heading( const char* name, FILE* file ) { fprintf( file, ".SS %c%s\n", name[0] - 'a' + 'A', name + 1 ); }

static void print_option( const RfOption* option, FILE* file )
{
    char usage[128], usual[RF_DEFAULT_SIZE];
    rf_format_option( option, usage, sizeof usage );
    rf_format_default( option, usual );
    fputs( ".TP\n.B ", file );
    print_text( usage, file );
    fputc( '\n', file );
    print_text( option->help, file );
    if ( usual[0] != '\0' )
    {
        fputs( " (default: ", file );
        print_text( usual, file );
        fputc( ')', file );
    }
    fputc( '\n', file );
}

void rf_print_manual_section( const RfCommandTable* table, FILE* file )
{
    fprintf( file, ".SH \"reframe %s\"\n.B reframe %s\n[\\fIOPTIONS\\fR]", table->command, table->command );
    for ( int i = 0; i < table->file_count; ++i )
        fprintf( file, " \\fI%s\\fR%s", table->files[i], rf_file_dots( table, i ) );
    fputs( "\n.PP\n", file );
    print_text( table->summary, file );
    fputc( '\n', file );
    rf_list_options( table, file, print_heading, print_option );
}

// A paragraph for each AOV: its channels and what it is.
static void print_aovs( FILE* file )
{
    static const struct
    {
        const char* what;
        bool half;
    } rows[RF_AOV_ALPHA] = {
#define ROW( constant, name, letters, half, source, what ) { what, half },
        RF_AOV_LIST( ROW )
#undef ROW
    };
    fputs( ".SH LAYERS\nWhat \\fB\\-\\-aov\\fR adds to the files; all but the last two are means over the frame's own samples:\n",
           file );
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
    {
        fputs( ".TP\n.B", file );
        for ( const char* c = rf_aov_letters( (RfAov)i ); *c != '\0'; ++c )
            fprintf( file, " %s.%c", rf_aov_name( (RfAov)i ), *c );
        fprintf( file, "\n%s%s\n", rows[i].what, rows[i].half ? "; 16-bit floats unless \\fB\\-\\-float\\fR is given" : "" );
    }
}

void rf_print_manual_tail( FILE* file )
{
    print_aovs( file );
    fputs(
        ".PP\n"
        "All other layers are 32-bit floats.\n"
        ".SH FLICKER\n"
        "F1 is the root mean square change of the error from one frame to the next; phi is its square over the sum of the\n"
        "mean square errors of the two frames: 1 is independent noise in each frame, 0 a frozen error, 2 an alternating one.\n"
        "Without a reference the change of the picture along the motion layers is measured, over the pixels that were visible\n"
        "before (the coverage), and the size of the error comes from the variance layers. With a reference and motion layers\n"
        "both are reported, in place and along the motion. Layers may lie in any part of a file, all with one data window.\n"
        "The borders of Reframe's sliding groups are the pairs with a frame in fewer groups than those in the middle of the\n"
        "path, or in cut ones: 2N at each end of it for \\fB\\-\\-group N\\fR. The spectrum is of windows of 16 frames: slow "
        "drift has periods\n"
        "of 8 frames and more, boiling shorter ones.\n"
        ".SH REPORT\n"
        "The page is one file that loads nothing else, so it opens without a network. It stores the logarithm of light: the\n"
        "exposure slider shows no bands. The space bar plays, the arrow keys step and change the exposure, a click on a curve\n"
        "shows that frame. Frames that a sequence lacks are named; pairs that lack motion layers are left out of the flicker\n"
        "along the motion. With a reference the error can be shown as a picture, grey where there is none. Of a folder with\n"
        "more than one sequence name one, as \\fIDIR/shot.####.exr\\fR. Output of \\fBrender \\-\\-json\\fR and \\fBcost "
        "\\-\\-json\\fR\n"
        "beside the frames is used.\n"
        ".SH PLANNING\n"
        "\\fB\\-\\-group auto\\fR takes the smallest group within 10 % of the best gain at fixed ray costs, among those "
        "whose films take\n"
        "at most half of \\fB\\-\\-memory\\fR, that need a single sweep over the path, and that round \\fB\\-\\-spp\\fR up by at "
        "most a quarter.\n"
        "No clock is involved. Memory for \\fB\\-\\-adaptive auto\\fR does not count; extra samples are off where they would "
        "need several\n"
        "sweeps. The gain beside it is by measured costs, with sweeps. With \\fB\\-\\-noise\\fR, \\fB\\-\\-flicker\\fR or "
        "\\fB\\-\\-time\\fR rays and\n"
        "seconds of the rows are upper limits; the verdict predicts the time to reach a noise or flicker from short "
        "renders.\n"
        ".SH TUNING\n"
        "2N+1 frames are rendered as one group with few samples, twice with different seeds: half the squared "
        "difference\n"
        "is the error, and 1 / (relMSE x CPU seconds of a frame) the efficiency. All settings are tried at the same places of\n"
        "the path and of the picture, the better ones then at more of them. The first round is always finished. With\n"
        "\\fB\\-\\-goal flicker\\fR F1 squared takes the place of relMSE.\n",
        file );
    fputs( ".SH COST\n"
           "Frames from three places of the path are rendered with 2, 4, 8, ... samples, by path tracing and in one group with\n"
           "tiles, twice each with different seeds: half the squared difference is the error. The ratio of times at "
           "equal error is\n"
           "that of relMSE x seconds over all renders, its interval by leaving out one place and sample count at a time. The "
           "seconds of\n"
           "all frames include the more expensive ends of the path, sweeps and loading. Two samples are always rendered.\n"
           ".SH \"EXIT STATUS\"\n"
           "0: done. 1: it failed, with one line on standard error that says what, where and what to do.\n"
           "2: the command line is wrong. 130: interrupted, with everything finished so far kept: \\fBrender \\-\\-resume\\fR\n"
           "goes on, after \\fB\\-\\-overwrite\\fR both together, which keep what is of the same scene, path and settings and\n"
           "replace the rest; its \\fB\\-\\-json\\fR is written with what is finished.\n"
           ".SH EXAMPLES\n"
           ".EX\n"
           "reframe info scene.glb\n"
           "reframe tune scene.glb \\-\\-spp 28 \\-\\-memory 2G\n"
           "reframe tune scene.glb \\-\\-size 960x540 \\-\\-memory 2G \\-\\-svg tune.svg\n"
           "reframe render scene.glb \\-o out/shot.####.exr \\-\\-size 960x540 \\-\\-spp 28\n"
           "reframe render scene.glb \\-o out/shot.####.exr \\-\\-resume \\-\\-aov depth,motion\n"
           "reframe compare out/shot.####.exr reference.####.exr\n"
           "reframe flicker out/shot.####.exr \\-\\-reference reference.####.exr \\-\\-png slit.png\n"
           "reframe report out \\-\\-reference reference \\-o report.html\n"
           "reframe png out/shot.0012.exr shot.png \\-\\-exposure 1\n"
           "reframe png out png \\-\\-view agx \\-\\-look punchy\n"
           "reframe png out png/shot.####.png \\-\\-layer depth.Z\n"
           ".EE\n",
           file );
}
