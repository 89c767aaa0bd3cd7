// Lets Node load packages that are written for bundlers: imports without an ending, and of folders. Workers of Jolt's build with
// SIMD never begin under Node: they read `workerData` of a promise in place of the module.
import { register } from "node:module";

const broken = 'await import("node:worker_threads").workerData', mended = '(await import("node:worker_threads")).workerData';

export async function resolve(specifier, context, next) {
    if (!specifier.startsWith(".")) return next(specifier, context);
    for (const ending of ["", ".js"])
        try {
            return await next(specifier + ending, context);
        } catch {
            // the next one
        }
    return next(`${specifier}/index.js`, context);
}

export async function load(url, context, next) {
    const loaded = await next(url, context);
    if (url.includes("jolt-physics.multithread")) loaded.source = new TextDecoder().decode(loaded.source).replace(broken, mended);
    return loaded;
}

if (!import.meta.url.includes("?hooks")) register(`${import.meta.url}?hooks`);
