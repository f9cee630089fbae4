// Sheets of all predictors and the paired comparison with the diagnosis.

#include "jaculus/evaluation/score.h"

#include <cassert>
#include <stdexcept>

#include "evaluation/baselines.h"
#include "evaluation/estimates.h"
#include "evaluation/metrics.h"
#include "jaculus/core/error.h"

namespace jaculus::evaluation {

Score score_predictions(const std::vector<CaseTruth>& truths,
                        const std::map<std::string, std::vector<Prediction>>& predictions) {
  assert(predictions.count("diagnosis") == 1 &&
         "score_predictions: the diagnosis' own answers are missing");
  Score score;
  score.truths = truths;
  score.sealed = count_of(truths);
  for (const auto& [predictor, given] : predictions) {
    assert(given.size() == truths.size() && "score_predictions: one answer a truth");
    const bool diagnosis = predictor == "diagnosis";
    std::vector<Prediction> rated = given;
    if (!diagnosis && !states_probability(predictor)) give_confidence(truths, rated);
    Metrics metrics = evaluation::compute_metrics(predictor, truths, rated);
    score.metrics.insert(diagnosis ? score.metrics.begin() : score.metrics.end(),
                         std::move(metrics));
  }

  const Metrics& own = score.metrics.front();
  for (std::size_t s = 1; s < score.metrics.size(); ++s) {
    const Metrics& other = score.metrics[s];
    std::vector<double> log_gain, credit_gain;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      log_gain.push_back(own.scores[i].log_score - other.scores[i].log_score);
      credit_gain.push_back(own.scores[i].credit - other.scores[i].credit);
    }
    score.comparisons.push_back(
        {other.predictor, evaluation::mean(log_gain), evaluation::mean(credit_gain)});
  }

  return score;
}

}  // namespace jaculus::evaluation
