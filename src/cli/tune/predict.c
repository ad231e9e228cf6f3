#include "cli/tune/predict.h"

#include "cli/messages.h"

RfCostPrediction rf_predict_goals( const RfCostJob* job, const RfCostCurve* curve, int per_sweep )
{
    const RfRenderSettings* s = job->settings;
    RfCostPrediction noise = { 0 }, flicker = { 0 };
    if ( s->noise > 0.0 )
        noise = rf_predict_cost( job, curve, s->noise, per_sweep );
    if ( s->flicker > 0.0 )
        flicker = rf_predict_flicker_cost( job, curve, s->flicker, per_sweep );
    bool missing = ( s->noise > 0.0 && noise.spp == 0 ) || ( s->flicker > 0.0 && flicker.spp == 0 );
    return missing ? ( RfCostPrediction ){ 0 } : noise.spp > flicker.spp ? noise : flicker;
}

json_t* rf_predicted_json( const RfCostPrediction* predicted )
{
    if ( predicted->spp == 0 )
        return json_null();
    return json_pack( "{s:i, s:o}", "spp", predicted->spp, "seconds", rf_json_number( predicted->seconds ) );
}
