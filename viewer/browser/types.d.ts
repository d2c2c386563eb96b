// The one global of meshcat's bundle, what our pages put on the window, and what TypeScript 4.8 does not know yet.
declare const MeshCat: any;
interface Window {
  pilegrasp: any;
  picture: any;
  live: any;
  study: any;
}
interface Array<T> {
  findLast(test: (value: T, index: number) => unknown): T | undefined;
  findLastIndex(test: (value: T, index: number) => unknown): number;
  toReversed(): T[];
  toSorted(compare: (a: T, b: T) => number): T[];
}
declare class DecompressionStream {
  constructor(format: string);
  readable: any;
  writable: any;
}
