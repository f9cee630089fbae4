// Sheets of all answerers and the paired comparison with the diagnosis.

#include <cassert>
#include <stdexcept>

#include "evaluation/estimates.h"
#include "evaluation/sheet.h"
#include "jaculus/core/error.h"

namespace jaculus {

Score score_answers(const std::vector<SealedTruth>& truths,
                    const std::map<std::string, std::vector<CaseAnswer>>& answers) {
  assert(answers.count("diagnosis") == 1 && "score_answers: the diagnosis' own answers are missing");
  Score score;
  score.truths = truths;
  for (const auto& [answerer, given] : answers) {
    assert(given.size() == truths.size() && "score_answers: one answer a truth");
    const bool diagnosis = answerer == "diagnosis";
    std::vector<CaseAnswer> rated = given;
    if (!diagnosis) evaluation::give_confidence(truths, rated);
    ScoreSheet sheet = evaluation::make_sheet(answerer, truths, rated);
    score.sheets.insert(diagnosis ? score.sheets.begin() : score.sheets.end(), std::move(sheet));
  }
  const ScoreSheet& own = score.sheets.front();
  for (std::size_t s = 1; s < score.sheets.size(); ++s) {
    const ScoreSheet& other = score.sheets[s];
    std::vector<double> log_gain, credit_gain;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      log_gain.push_back(own.marks[i].log_score - other.marks[i].log_score);
      credit_gain.push_back(own.marks[i].credit - other.marks[i].credit);
    }
    score.comparisons.push_back({other.answerer, evaluation::mean(log_gain), evaluation::mean(credit_gain)});
  }
  return score;
}

}  // namespace jaculus
