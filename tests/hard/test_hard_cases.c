// Runs the hard cases (hard.h).
//
//     test_hard_cases                        the short form: every case, few seeds
//     test_hard_cases --measure [--rows F]   with the statistics of tests/hard/README.md; results as lines of JSON
//     test_hard_cases --list                 the cases as lines of JSON
//     test_hard_cases NAME...                some of them
#include "base/float_traps.h"
#include "hard/hard.h"

#include <stdlib.h>
#include <string.h>

static const HardCase* const s_tables[] = { g_hard_eyes,      g_hard_lenses,    g_hard_geometry,
                                            g_hard_light,     g_hard_materials, g_hard_projections,
                                            g_hard_transport, g_hard_numbers,   g_hard_poisson };

#define TABLES ( sizeof s_tables / sizeof *s_tables )

static bool is_asked( const HardCase* c, int count, char** names )
{
    bool asked = count == 0;
    for ( int i = 0; i < count; ++i )
        asked = asked || strcmp( names[i], c->name ) == 0;
    return asked;
}

// No cases by the rule of scripts/hard-cases, but rendered with them: nothing was found whose loss they show.
static const char* why_unprotected( const char* name )
{
    static const char* const rows[][2] = {
        { "phong-100", "an ordinary lobe, between the hard ones" },
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
    static const char* const references[] = { "double", "plain", "value", "black", "finite", "input" };
    for ( size_t t = 0; t < TABLES; ++t )
    {
        for ( const HardCase* c = s_tables[t]; c->name != NULL; ++c )
            printf( "{\"case\": \"%s\", \"hard\": \"%s\", \"from\": \"%s\", \"reference\": \"%s\", \"factor\": %g, \"why\": "
                    "\"%s\"}\n",
                    c->name, c->hard, c->from, references[c->reference], c->factor, why_unprotected( c->name ) );
    }
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
        if ( strcmp( argv[first], "--measure" ) == 0 )
            form = ( HardForm ){ .seeds = 16, .spp = 7, .reference = 4, .statistics = true, .rows = form.rows };
        else if ( strcmp( argv[first], "--rows" ) == 0 && first + 1 < argc )
            form.rows = fopen( argv[++first], "w" );
        else
        {
            fprintf( stderr, "test_hard_cases: %s: there are --list, --measure and --rows FILE\n", argv[first] );
            return 2;
        }
    }
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
    if ( form.rows != NULL )
        fclose( form.rows );
    printf( "%d of %d hard cases hold\n", run - failed, run );
    return failed > 0 || run == 0;
}
