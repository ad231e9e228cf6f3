// The verdict of reframe compare in words.
#include "support/test.h"
#include "cli/commands.h"

static size_t s_clipped[2];

static void check_verdict( const RfErrorMetrics* metrics, const int* frame, const char* wanted )
{
    char text[1024];
    rf_error_verdict( metrics, s_clipped, frame, text, sizeof text );
    assert_string_equal( text, wanted );
}

TEST( test_verdict_says_bias_noise_and_worst_pixel )
{
    RfErrorMetrics m = { .relmse = 0.03,
                         .relmse_trimmed = 0.029,
                         .mse = 0.01,
                         .max = 3.0,
                         .bias = 0.001,
                         .bias_low = -0.002,
                         .bias_high = 0.004,
                         .reference_mean = 0.5,
                         .worst = { 0, 12, 34, 12.0 } };
    check_verdict( &m, &( int ){ 7 },
                   "no significant bias: mean error +0.2 % (95 %: -0.4 to +0.8 %); relMSE 0.03 (about 10 % noise per pixel); "
                   "worst pixel (12, 34) in frame 7, off by 2e+02 %" );
    m.bias_low = 0.0005;
    m.relmse_trimmed = 0.0003;
    m.worst.relative = 0.75;
    check_verdict( &m, NULL,
                   "significant bias, too bright: mean error +0.2 % (95 %: +0.1 to +0.8 %); relMSE 0.03 (about 10 % noise per "
                   "pixel, 1 % without the worst 0.1 % of pixels); worst pixel (12, 34), off by 50 %" );
    m.bias = m.bias_high = -0.001;
    m.bias_low = -0.003;
    m.reference_mean = 0.0; // nothing to be relative to
    m.relmse_trimmed = 0.03;
    m.worst.frame = -1;
    check_verdict( &m, NULL,
                   "significant bias, too dark: mean error -0.001 (95 %: -0.003 to -0.001); relMSE 0.03 (about 10 % noise per "
                   "pixel)" );
    m.bias_low = m.bias_high = NAN;
    check_verdict( &m, NULL,
                   "mean error -0.001 (too few pixels to tell bias from noise); relMSE 0.03 (about 10 % noise per pixel)" );
    m.bias = -0.08; // more than half of it stands still
    check_verdict( &m, NULL,
                   "mean error -0.08 (too few pixels to tell bias from noise); relMSE 0.03 (about 10 % error per pixel)" );
    s_clipped[1] = 3; // what is missing there is no bias of A
    check_verdict(
        &m, NULL,
        "no verdict on bias, clipped pixels are compared (0 of A, 3 of B): mean error -0.08; relMSE 0.03 (about 10 % error "
        "per pixel)" );
    s_clipped[1] = 0;
    m = ( RfErrorMetrics ){ .worst = { .frame = -1 } };
    check_verdict( &m, NULL, "no difference: all pixels are identical" );
    m.nan = 1;
    check_verdict( &m, NULL, "no error can be reported: there are NaN or infinite values" );
}
