// Plots: ticks, positions on paper, and valid XML for any text.
#include "support/cli_run.h"
#include "support/test.h"
#include "measure/plot.h"

static char* draw( const RfPlot* plot )
{
    size_t size;
    RfError error;
    static char* svg; // gcc 12 takes what comes back for the address of a local one
    assert_int_equal( rf_draw_plot( plot, &svg, &size, &error ), RF_OK );
    assert_int_equal( size, strlen( svg ) );
    return svg;
}

static int count( const char* text, const char* part )
{
    int n = 0;
    for ( const char* at = strstr( text, part ); at != NULL; at = strstr( at + 1, part ) )
        n += 1;
    return n;
}

static void expect_well_formed( const char* svg )
{
    cli_write( "plot.svg", svg, strlen( svg ) );
    cli_expect(
        cli_run(
            "python3 -c \"import xml.dom.minidom as m; d = m.parse('plot.svg').documentElement; assert d.tagName == 'svg'\"" ),
        0, NULL );
}

TEST( test_ticks_are_round )
{
    double t[RF_PLOT_TICKS];
    assert_int_equal( rf_plot_ticks( true, 1.0, 100.0, t, RF_PLOT_TICKS ), 7 );
    static const double expected[] = { 1, 2, 5, 10, 20, 50, 100 };
    for ( int i = 0; i < 7; ++i )
        assert_true( fabs( t[i] - expected[i] ) < 1e-9 * expected[i] );
    assert_int_equal( rf_plot_ticks( true, 0.9e-5, 1.1e3, t, RF_PLOT_TICKS ), 9 ); // powers of ten alone
    assert_true( fabs( t[8] - 1000.0 ) < 1e-6 );
    assert_int_equal( rf_plot_ticks( false, 0.0, 1.0, t, RF_PLOT_TICKS ), 6 );
    assert_true( t[0] == 0.0 && fabs( t[1] - 0.2 ) < 1e-12 && fabs( t[5] - 1.0 ) < 1e-12 );
    assert_int_equal( rf_plot_ticks( false, -13.0, 8.0, t, RF_PLOT_TICKS ), 4 ); // by 5
    assert_true( t[0] == -10.0 && t[2] == 0.0 && t[3] == 5.0 );
    assert_int_equal( rf_plot_ticks( true, 22.0, 110.0, t, RF_PLOT_TICKS ), 4 ); // less than a decade
    assert_true( t[0] == 40.0 && t[3] == 100.0 );
    assert_int_equal( rf_plot_ticks( true, 0.0, 8.0, t, RF_PLOT_TICKS ), 0 );
    assert_int_equal( rf_plot_ticks( false, 8.0, 8.0, t, RF_PLOT_TICKS ), 0 );
    for ( double low = 1e-30; low < 1e30; low *= 37.0 ) // any range: inside, ascending, enough, and never too many
    {
        for ( double span = 1.01; span < 1e40; span *= span )
        {
            for ( int log = 0; log < 2; ++log )
            {
                int n = rf_plot_ticks( log, low, low * span, t, RF_PLOT_TICKS );
                assert_true( n <= RF_PLOT_TICKS && n >= 3 );
                double air = 1e-6 * ( log ? low : low * ( span - 1.0 ) );
                for ( int i = 0; i < n; ++i )
                    assert_true( t[i] >= low - air && t[i] <= low * span * ( 1.0 + 1e-6 ) && ( i == 0 || t[i] > t[i - 1] ) );
            }
        }
    }
}

// The paper's corners are those of axes with a given range; the middle of a
// logarithmic one is the geometric mean.
TEST( test_places_on_paper )
{
    double x[] = { 1.0, 10.0, 100.0, 1000.0, 10.0 }, y[] = { 0.0, 5.0, 10.0, 5.0, (double)NAN };
    RfPlotSeries series = { .name = "dots", .x = x, .y = y, .count = 5, .no_line = true };
    RfPlot plot = {
        .title = "t", .x = { "x", true, 1.0, 100.0 }, .y = { "y", false, 0.0, 10.0 }, .series = &series, .series_count = 1
    };
    AUTO_FREE char* svg = draw( &plot );
    assert_int_equal( count( svg, "<circle" ), 3 + 1 ); // outside and without a number: none; one in the legend
    double at[3][2];
    const char* c = svg;
    for ( int i = 0; i < 3; ++i )
    {
        c = strstr( c, "<circle" );
        assert_int_equal( sscanf( c, "<circle cx=\"%lf\" cy=\"%lf\"", at[i], at[i] + 1 ), 2 );
        c += 1;
    }
    assert_true( at[0][0] < at[1][0] && at[0][1] > at[1][1] );
    assert_true( fabs( at[0][0] + at[2][0] - 2.0 * at[1][0] ) < 0.3 && fabs( at[0][1] + at[2][1] - 2.0 * at[1][1] ) < 0.3 );
}

TEST( test_series_gaps_and_notes_are_drawn )
{
    double x[] = { 1, 2, 3, 4, 5, 6 }, y[] = { 1, 2, -1, 3, 4, (double)INFINITY };
    RfPlotSeries series[] = { { .name = "gap", .x = x, .y = y, .count = 6 },
                              { .name = "fit", .x = x, .y = x, .count = 6, .dashed = true, .no_markers = true, .style = 3 } };
    RfPlotNote note = { 5.0, 4.0, "best" };
    RfPlot plot = { .title = "t",
                    .x = { "x", false, 0, 0 },
                    .y = { "y", true, 0, 0 },
                    .series = series,
                    .series_count = 2,
                    .notes = &note,
                    .note_count = 1 };
    AUTO_FREE char* svg = draw( &plot );
    const char* curve = strstr( svg, "clip-path=\"url(#plot)\"" );
    assert_non_null( curve );
    assert_int_equal( count( svg, ">best</text>" ), 1 );
    assert_int_equal( count( svg, "stroke-dasharray" ), 2 ); // and in the legend
    assert_int_equal( count( svg, "<circle" ), 4 + 1 + 2 );  // points, legend, ring at the point and at its word
    // a point that cannot be drawn interrupts the line
    char line[512] = "";
    const char* start = curve;
    while ( *start != '\n' )
        --start;
    snprintf( line, sizeof line, "%.*s", (int)( curve - start ), start );
    assert_true( count( line, "M" ) == 2 && count( line, "L" ) == 2 );
    expect_well_formed( svg );
}

TEST( test_any_text_is_valid_xml )
{
    static const char* const hostile[] = { "<svg>&amp;\"'",
                                           "\xff\xfe half \xe2\x82",
                                           "tab\t\x01\x1f\n",
                                           "\xe2\x82\xac \xf0\x9f\x98\x80",
                                           "\xed\xa0\x80 \xef\xbf\xbf \xc0\xaf \xf4\x90\x80\x80",
                                           "" };
    double one = 3.0;
    for ( int i = 0; i < 6; ++i )
    {
        RfPlotSeries series = {
            .name = hostile[i], .x = &one, .y = &one, .count = 1, .labels = hostile + i, .show_labels = true, .style = i
        };
        RfPlotNote note = { one, one, hostile[i] };
        RfPlot plot = { .title = hostile[i],
                        .subtitle = hostile[i],
                        .x = { hostile[i], false, 0, 0 },
                        .y = { hostile[i], true, 0, 0 },
                        .series = &series,
                        .series_count = 1,
                        .notes = &note,
                        .note_count = 1 };
        char *svg = draw( &plot ), *again = draw( &plot );
        assert_string_equal( svg, again );
        assert_true( i != 3 || strstr( svg, hostile[i] ) != NULL );
        expect_well_formed( svg );
        free( svg );
        free( again );
    }
}

TEST( test_nothing_to_plot )
{
    double bad = (double)NAN;
    RfPlotSeries series = { .name = "none", .x = &bad, .y = &bad, .count = 1 };
    for ( int n = 0; n < 2; ++n )
    {
        RfPlot plot = {
            .title = "empty", .x = { "x", true, 0, 0 }, .y = { "y", false, 0, 0 }, .series = &series, .series_count = n
        };
        AUTO_FREE char* svg = draw( &plot );
        assert_null( strstr( svg, "nan" ) );
        assert_null( strstr( svg, "inf" ) );
        expect_well_formed( svg );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
