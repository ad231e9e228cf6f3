// Runs the hard cases (hard.h).
//
//     test_hard_cases                    the short form: every case, few seeds
//     test_hard_cases --measure          more seeds
//     test_hard_cases --table FILE       writes the results as a table in Markdown as well
//     test_hard_cases --list, --faults   the cases and the faults of base/fault.h as lines of JSON
//     test_hard_cases NAME...            some of the cases
#include "base/fault.h"
#include "base/float_traps.h"
#include "hard/hard.h"

#include <stdlib.h>
#include <string.h>

static const HardCase* const s_tables[] = { g_hard_eyes,      g_hard_lenses,      g_hard_geometry,  g_hard_light,
                                            g_hard_materials, g_hard_projections, g_hard_transport, g_hard_numbers,
                                            g_hard_poisson,   g_hard_moving,      g_hard_surfaces };

#define TABLES ( sizeof s_tables / sizeof *s_tables )

static bool is_asked( const HardCase* c, int count, char** names )
{
    bool asked = count == 0;
    for ( int i = 0; i < count; ++i )
        asked = asked || strcmp( names[i], c->name ) == 0;
    return asked;
}

// Why scripts/hard-cases need not know a fault that breaks the case.
static const char* why_unprotected( const char* name )
{
    static const char* const rows[][2] = {
        { "phong-100", "an ordinary lobe, between the hard ones" },
        { "sheen-1-grazing", "no term of sheen of roughness 1 is singular there" },
        { "curtain-lamp", "the side is part of the hit, and rays start on it as anywhere" },
        { "curtain-edge-on", "likewise" },
        { "curtain-flipped", "normals are turned to the side that is seen, as anywhere" },
        { "curtain-leaning", "likewise" },
        { "curtain-box", "likewise" },
        { "moves-singular", "normals of length 0 are replaced twice, where they are posed and where they are hit" },
        { "moves-no-area", "so are these, and the reader drops the triangles" },
        { "changes-sinks", "as lamp-on-surface, in groups" },
        { "changes-horizon", "cosines that are not positive bring nothing, as everywhere" },
        { "changes-shrinks", "triangles without an area are no lights, and have no normal to fail" },
        { "changes-polishes", "hits on what changes are of their own frame" },
    };
    for ( size_t i = 0; i < sizeof rows / sizeof *rows; ++i )
    {
        if ( strcmp( rows[i][0], name ) == 0 )
            return rows[i][1];
    }
    return "";
}

static void list( void )
{
    for ( size_t t = 0; t < TABLES; ++t )
    {
        for ( const HardCase* c = s_tables[t]; c->name != NULL; ++c )
            printf( "{\"case\": \"%s\", \"why\": \"%s\"}\n", c->name, why_unprotected( c->name ) );
    }
}

// The cases of a row of RF_FAULTS are separated by spaces.
static void list_fault( const char* name, const char* what, const char* cases )
{
    printf( "{\"fault\": \"%s\", \"protects\": \"%s\", \"cases\": [\"", name, what );
    for ( ; *cases != 0; ++cases )
        fputs( *cases == ' ' ? "\", \"" : ( char[] ){ *cases, 0 }, stdout );
    printf( "\"]}\n" );
}

static void list_faults( void )
{
#define LIST( name, what, cases ) list_fault( #name, what, cases );
    RF_FAULTS( LIST )
}

int main( int argc, char** argv )
{
    HardForm form = { .seeds = 5, .spp = 7, .reference = 4, .statistics = true };
#ifdef REFRAME_SANITIZED
    form = ( HardForm ){ .seeds = 1, .spp = 7, .reference = 1, .statistics = false };
#endif
    int first = 1, failed = 0, run = 0;
    rf_enable_float_traps(); // of builds with REFRAME_TRAP
    for ( ; first < argc && strncmp( argv[first], "--", 2 ) == 0; ++first )
    {
        if ( strcmp( argv[first], "--list" ) == 0 )
        {
            list();
            return 0;
        }
        if ( strcmp( argv[first], "--faults" ) == 0 )
        {
            list_faults();
            return 0;
        }
        if ( strcmp( argv[first], "--measure" ) == 0 )
            form = ( HardForm ){ .seeds = 16, .spp = 7, .reference = 4, .statistics = true, .table = form.table };
        else if ( strcmp( argv[first], "--table" ) == 0 && first + 1 < argc )
            form.table = fopen( argv[++first], "w" );
        else
        {
            fprintf( stderr, "test_hard_cases: %s: there are --list, --faults, --measure and --table FILE\n", argv[first] );
            return 2;
        }
    }
    hard_begin_table( &form );
    for ( size_t t = 0; t < TABLES; ++t )
    {
        for ( const HardCase* c = s_tables[t]; c->name != NULL; ++c )
        {
            if ( !is_asked( c, argc - first, argv + first ) )
                continue;
            failed += !hard_run( c, &form );
            run += 1;
        }
    }
    if ( form.table != NULL )
        fclose( form.table );
    printf( "%d of %d hard cases hold\n", run - failed, run );
    return failed > 0 || run == 0;
}
