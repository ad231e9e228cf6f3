// The estimators there are. A further one is a folder and a row in estimators.c.
#ifndef REFRAME_ESTIMATORS_ESTIMATORS_H
#define REFRAME_ESTIMATORS_ESTIMATORS_H

#include "reframe/render.h"

// The name of estimator `index`, from 0; NULL behind the last.
const char* rf_estimator_name_at( int index );

#endif
