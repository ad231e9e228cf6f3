// Numbers as people read them: "1.23 M", "4.5 GB", "3 min 20 s".
#ifndef REFRAME_CLI_REPORT_REPORT_NUMBERS_H
#define REFRAME_CLI_REPORT_REPORT_NUMBERS_H

void rf_format_count( double count, char text[32] );
void rf_format_bytes( double bytes, char text[32] );
void rf_format_seconds( double seconds, char text[32] );

#endif
