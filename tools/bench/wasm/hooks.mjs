// Lets Node load packages that are written for bundlers: imports of files without an extension, and of folders. Also
// corrects Jolt's build with SIMD, whose workers never begin under Node because they read `workerData` of a promise,
// not of the module.
import { register } from "node:module";

const broken = 'await import("node:worker_threads").workerData', mended = '(await import("node:worker_threads")).workerData';

export async function resolve(specifier, context, next) {
    if (!specifier.startsWith(".")) return next(specifier, context);
    for (const ending of ["", ".js"])
        try {
            return await next(specifier + ending, context);
        } catch {
            // tries the next ending
        }
    return next(`${specifier}/index.js`, context);
}

export async function load(url, context, next) {
    const loaded = await next(url, context);
    if (url.includes("jolt-physics.multithread")) loaded.source = new TextDecoder().decode(loaded.source).replace(broken, mended);
    return loaded;
}

if (!import.meta.url.includes("?hooks")) register(`${import.meta.url}?hooks`);
