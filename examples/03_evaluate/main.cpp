// SPDX-License-Identifier: MIT
// Compares a trajectory with ground truth: evaluate GROUNDTRUTH ESTIMATE
#include <edvo/eval/evaluate.hpp>
#include <edvo/io/trajectory_file.hpp>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: evaluate GROUNDTRUTH ESTIMATE\n";
    return 2;
  }
  const edvo::Trajectory truth = edvo::read_trajectory(argv[1]).trajectory;
  const edvo::Trajectory estimate = edvo::read_trajectory(argv[2]).trajectory;

  edvo::EvalOptions options;
  options.rpe.delta = edvo::parse_delta("0.5s");
  const edvo::Evaluation evaluation = edvo::evaluate(truth, estimate, options);

  std::cout << edvo::describe_protocol(options) << '\n'
            << "ATE " << evaluation.ate.distance.rmse << " m over " << evaluation.matches.size()
            << " poses\n";
  if (evaluation.rpe)
    std::cout << "RPE " << evaluation.rpe->translation.rmse << " m, "
              << evaluation.rpe->rotation.rmse << " deg per 0.5 s\n";
  return 0;
} catch (const edvo::Error& error) {
  std::cerr << error.what() << '\n';
  return static_cast<int>(error.code());
}
