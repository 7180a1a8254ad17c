// SPDX-License-Identifier: MIT
// The same networks through ONNX Runtime, for comparison: npm install --ignore-scripts onnxruntime-node
//   node onnxruntime.mjs THREADS ROUNDS FILE.onnx...
import ort from 'onnxruntime-node';

const [threads, rounds, ...files] = process.argv.slice(2);
const image = new ort.Tensor('float32', new Float32Array(3 * 480 * 640).fill(100), [1, 3, 480, 640]);
for (const file of files) {
  const session = await ort.InferenceSession.create(file, {
    intraOpNumThreads: Number(threads), interOpNumThreads: 1, graphOptimizationLevel: 'all'});
  const times = [];
  for (let round = 0; round <= Number(rounds); ++round) {
    const start = performance.now();
    await session.run({[session.inputNames[0]]: image});
    if (round > 0) times.push(performance.now() - start);
  }
  times.sort((a, b) => a - b);
  console.log(`${file}: median ${times[times.length >> 1].toFixed(1)} ms, least ${times[0].toFixed(1)} ms`);
}
