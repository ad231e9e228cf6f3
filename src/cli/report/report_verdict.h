// The page in a sentence: which sequence reaches the same noise in less time, how noisy it is.
#ifndef REFRAME_CLI_REPORT_REPORT_VERDICT_H
#define REFRAME_CLI_REPORT_REPORT_VERDICT_H

#include "cli/report/report_command.h"

// { text, basis, worst_frame }: the sentence, what its figures rest on, and the number of the frame with the largest error, null where
// no error is known or there is one frame.
json_t* rf_page_verdict_json( const RfPageRun* report );

#endif
