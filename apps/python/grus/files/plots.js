// SPDX-License-Identifier: LGPL-3.0-or-later
// Curves as SVG that tell their values under the pointer and can be zoomed: those of grus watch, drawn here, and those
// of reports, which matplotlib has drawn. A figure's data: {box: [left, top, right, bottom], x: [low, high], y: [low,
// high], log_x, log, series: [{label, x, y, limits, log}]}, box in the units of its SVG; limits of a second axis.
"use strict"
const grusPlots = (() => {
  const COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"]
  const NS = "http://www.w3.org/2000/svg"
  const make = (parent, name, attributes, text) => {
    const node = parent.appendChild(document.createElementNS(NS, name))
    for (const [k, v] of Object.entries(attributes)) node.setAttribute(k, v)
    if (text !== undefined) node.textContent = text
    return node
  }
  const number = v => v === 0 ? "0" : Math.abs(v) < 1e-3 || Math.abs(v) >= 1e5 ? v.toExponential(3).replace(/\.?0+e/, "e") : String(+v.toPrecision(4))

  function ends(values, log) {
    const seen = values.filter(v => isFinite(v) && (!log || v > 0))
    if (!seen.length) return [0, 1]
    let low = Math.min(...seen), high = Math.max(...seen)
    if (log) return [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high) + 1e-9)]
    const room = 0.04 * (high - low) || 0.5 * Math.abs(high) || 0.5
    return [low - room, high + room]
  }
  function ticks([low, high], log) {
    if (log) {
      const first = Math.round(Math.log10(low)), last = Math.round(Math.log10(high)), step = Math.max(1, Math.ceil((last - first) / 6))
      return Array.from({length: Math.floor((last - first) / step) + 1}, (_, k) => 10 ** (first + k * step))
    }
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough))
    const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= rough)
    const found = []
    for (let k = Math.ceil(low / step); k * step <= high; ++k) found.push(k * step)
    return found
  }
  // Where a value lies in the SVG, and back.
  const place = (v, [low, high], from, to, log) =>
    log ? from + (to - from) * Math.log(v / low) / Math.log(high / low) : from + (to - from) * (v - low) / (high - low)
  const value = (p, [low, high], from, to, log) => {
    const part = (p - from) / (to - from)
    return log ? low * (high / low) ** part : low + part * (high - low)
  }

  function draw(figure, plot) {
    const w = 560, lines = Math.ceil(plot.series.length / 3), h = 330 + 16 * lines
    const svg = document.createElementNS(NS, "svg")
    svg.setAttribute("viewBox", `0 0 ${w} ${h}`)
    svg.setAttribute("role", "img")
    svg.setAttribute("font-size", 12)
    make(svg, "title", {}, plot.title)
    const box = [62, 28, w - 14, 280]
    const data = {box, log: plot.log, log_x: false, series: plot.series}
    data.x = ends(plot.series.flatMap(s => s.x), false)
    data.y = ends(plot.series.flatMap(s => s.y), plot.log)
    make(svg, "text", {x: (box[0] + box[2]) / 2, y: 18, "text-anchor": "middle", "font-size": 14}, plot.title)
    for (const t of ticks(data.x, false)) {
      const x = place(t, data.x, box[0], box[2])
      make(svg, "line", {x1: x, x2: x, y1: box[1], y2: box[3], stroke: "#ddd"})
      make(svg, "text", {x, y: box[3] + 15, "text-anchor": "middle"}, number(t))
    }
    for (const t of ticks(data.y, plot.log)) {
      const y = place(t, data.y, box[3], box[1], plot.log)
      make(svg, "line", {x1: box[0], x2: box[2], y1: y, y2: y, stroke: "#ddd"})
      make(svg, "text", {x: box[0] - 5, y: y + 4, "text-anchor": "end"}, number(t))
    }
    make(svg, "rect", {x: box[0], y: box[1], width: box[2] - box[0], height: box[3] - box[1], fill: "none", stroke: "#555"})
    make(svg, "text", {x: (box[0] + box[2]) / 2, y: box[3] + 33, "text-anchor": "middle"}, plot.x)
    make(svg, "text", {x: 12, y: (box[1] + box[3]) / 2, "text-anchor": "middle", transform: `rotate(-90 12 ${(box[1] + box[3]) / 2})`}, plot.y)
    plot.series.forEach((s, k) => {
      const points = s.x.map((x, i) => [x, s.y[i]]).filter(p => !plot.log || p[1] > 0).map(p =>
        place(p[0], data.x, box[0], box[2]).toFixed(1) + "," + place(p[1], data.y, box[3], box[1], plot.log).toFixed(1))
      const colour = COLOURS[k % COLOURS.length]
      const line = make(svg, "polyline", {points: points.join(" "), fill: "none", stroke: colour, "stroke-width": 1.6})
      make(line, "title", {}, s.label)
      const x = box[0] + (k % 3) * (box[2] - box[0]) / 3, y = box[3] + 52 + 16 * Math.floor(k / 3)
      make(svg, "line", {x1: x, x2: x + 16, y1: y - 4, y2: y - 4, stroke: colour, "stroke-width": 3})
      make(svg, "text", {x: x + 20, y}, s.label.length > 22 ? s.label.slice(0, 21) + "…" : s.label)
    })
    figure.replaceChildren(svg)
    return data
  }

  // Values under the pointer; the wheel with Ctrl or two clicks zoom, a drag moves what is zoomed, Escape or two clicks
  // show all again.
  function follow(figure, data) {
    figure.grus = data
    const svg = figure.querySelector("svg"), whole = svg.getAttribute("viewBox")
    if (figure.seen !== whole) figure.zoom = null
    figure.seen = whole
    if (figure.zoom) svg.setAttribute("viewBox", figure.zoom)
    const size = parseFloat(whole.split(" ")[2])
    const old = svg.querySelector(".told")
    if (old) old.remove()
    const told = make(svg, "g", {class: "told", visibility: "hidden", "font-size": size / 45, "pointer-events": "none"})
    const at = e => {
      const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(svg.getScreenCTM().inverse())
      return [p.x, p.y]
    }
    const hide = () => told.setAttribute("visibility", "hidden")
    svg.onpointermove = e => {
      const d = figure.grus, [px, py] = at(e), b = d.box
      if (figure.held) {
        const v = figure.held.view, scale = v[2] / svg.clientWidth
        zoomTo([v[0] - (e.clientX - figure.held.x) * scale, v[1] - (e.clientY - figure.held.y) * scale, v[2], v[3]])
        return
      }
      if (px < b[0] || px > b[2] || py < b[1] || py > b[3]) return hide()
      let best = null
      for (const s of d.series)
        s.x.forEach((x, i) => {
          const own = s.limits !== undefined
          const q = [place(x, d.x, b[0], b[2], d.log_x), place(s.y[i], own ? s.limits : d.y, b[3], b[1], own ? s.log : d.log)]
          const far = (q[0] - px) ** 2 + (q[1] - py) ** 2
          if (isFinite(far) && (!best || far < best.far)) best = {far, q, text: `${s.label ? s.label + ": " : ""}${number(x)}, ${number(s.y[i])}`}
        })
      told.replaceChildren()
      told.setAttribute("visibility", "visible")
      const text = best ? best.text : `${number(value(px, d.x, b[0], b[2], d.log_x))}, ${number(value(py, d.y, b[3], b[1], d.log))}`
      const q = best ? best.q : [px, py], left = q[0] > (b[0] + b[2]) / 2
      make(told, "circle", {cx: q[0], cy: q[1], r: size / 140, fill: "none", stroke: "#000", "stroke-width": size / 400})
      make(told, "text", {x: q[0] + (left ? -1 : 1) * size / 70, y: q[1] - size / 70, "text-anchor": left ? "end" : "start",
        "paint-order": "stroke", stroke: "#fff", "stroke-width": size / 150}, text)
    }
    svg.onpointerleave = () => { hide(); figure.held = null }
    const view = () => svg.getAttribute("viewBox").split(" ").map(Number)
    const zoomTo = v => {
      figure.zoom = v.join(" ")
      svg.setAttribute("viewBox", figure.zoom)
    }
    const all = () => { figure.zoom = null; svg.setAttribute("viewBox", whole) }
    const zoom = (e, by) => {
      const [x, y] = at(e), v = view(), full = whole.split(" ").map(Number)
      if (v[2] * by >= full[2]) return all()
      if (v[2] * by > full[2] / 60) zoomTo([x - (x - v[0]) * by, y - (y - v[1]) * by, v[2] * by, v[3] * by])
    }
    svg.onwheel = e => {
      if (!e.ctrlKey && !figure.zoom) return  // the page scrolls
      e.preventDefault()
      zoom(e, e.deltaY > 0 ? 1.25 : 0.8)
    }
    svg.ondblclick = e => figure.zoom ? all() : zoom(e, 0.4)
    svg.onpointerdown = e => { if (figure.zoom) { figure.held = {x: e.clientX, y: e.clientY, view: view()}; hide() } }
    svg.onpointerup = () => figure.held = null
    figure.tabIndex = 0
    figure.onkeydown = e => { if (e.key === "Escape") all() }
  }

  function show(parent, plots) {
    while (parent.children.length > plots.length) parent.lastChild.remove()
    plots.forEach((plot, k) => {
      const figure = parent.children[k] || parent.appendChild(document.createElement("figure"))
      const text = JSON.stringify(plot)
      if (figure.text === text || figure.held) return
      figure.text = text
      follow(figure, draw(figure, plot))
    })
  }
  return {show, follow, place, value, ticks, number}
})()
