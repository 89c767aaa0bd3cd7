// Runs a WebAssembly program of the matrix under Node, in the folder "." of this process.
//
//   node wasm_host.mjs PROGRAM.wasm ARGUMENT...
import { readFile } from "node:fs/promises";
import { argv, exit } from "node:process";
import { WASI } from "node:wasi";

const wasi = new WASI({ version: "preview1", args: argv.slice(2), env: {}, preopens: { ".": "." }, returnOnExit: true });
const module = await WebAssembly.compile(await readFile(argv[2]));
// Debian's Node 18 has no getImportObject.
const imports = wasi.getImportObject?.() ?? { wasi_snapshot_preview1: wasi.wasiImport };
exit(wasi.start(await WebAssembly.instantiate(module, imports)));
