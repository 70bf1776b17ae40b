// The style sheet of the pages: light and dark, screen and paper. The colours of curves, `.c-…`,
// are those of Okabe and Ito ("Color Universal Design", 2008), distinguishable with every kind of
// colour vision; no meaning rests on colour alone.
#pragma once

namespace app::report {

inline constexpr const char* kPageStyle = R"css(
:root{--bg:#fff;--ink:#1b1d20;--soft:#5d646d;--line:#d9dde2;--panel:#f6f7f9;--grid:#e8ebee;
--grey:#868b92;--orange:#d98e00;--sky:#3fa0da;--green:#008f68;--yellow:#b59f00;--blue:#0069a8;
--red:#c64f00;--pink:#b8638f;--onfill:#fff;--better:0,105,168;--worse:198,79,0}
@media (prefers-color-scheme:dark){:root{--bg:#15181c;--ink:#e4e7ea;--soft:#9aa3ad;--line:#353b43;
--panel:#1d2126;--grid:#282d34;--grey:#8e959d;--orange:#e69f00;--sky:#6cc0f0;--green:#1fb38a;
--yellow:#d8c63a;--blue:#58a9e0;--red:#e8743a;--pink:#d592b6;--onfill:#101215;
--better:70,160,225;--worse:232,116,58}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",
Roboto,"Helvetica Neue",Arial,sans-serif}
main,header,footer{max-width:1040px;margin:0 auto;padding:0 20px}
header{padding-top:36px}
h1{font-size:30px;line-height:1.2;margin:0 0 6px;letter-spacing:-.01em}
h2{font-size:21px;margin:46px 0 8px;padding-top:10px;border-top:1px solid var(--line)}
h3{font-size:16px;margin:24px 0 6px}
p{margin:8px 0;max-width:46em}
ul{margin:6px 0;padding-left:1.3em;max-width:46em}
a{color:var(--blue)}
.lead{font-size:18px;color:var(--soft);margin:0 0 12px}
.facts,.small,figcaption,footer{font-size:13.5px;color:var(--soft)}
.warn{border-left:4px solid var(--red);background:var(--panel);padding:8px 12px}
nav{font-size:14px;margin:14px 0 0;display:flex;flex-wrap:wrap;gap:4px 16px}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(170px,1fr));gap:12px;margin:18px 0}
.tile{background:var(--panel);border-radius:8px;padding:12px 14px;font-size:13.5px;color:var(--soft);
line-height:1.4}
.tile b{display:block;font-size:25px;line-height:1.25;color:var(--ink);font-weight:650}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:16px;margin:14px 0}
.cards.narrow{grid-template-columns:repeat(auto-fill,minmax(225px,1fr))}
.card{border:1px solid var(--line);border-radius:8px;padding:12px 14px;break-inside:avoid;font-size:14.5px}
.card h3{margin:0 0 4px}
.card p{margin:6px 0 0}
.formula{font-family:Cambria,"STIX Two Math","DejaVu Serif",Georgia,serif;background:var(--panel);
border-radius:5px;padding:4px 8px;display:block;margin:6px 0;font-size:14.5px;overflow-wrap:anywhere}
.tag{font-size:11.5px;border:1px solid currentColor;border-radius:9px;padding:0 7px;margin-left:6px;
font-weight:500;color:var(--soft);white-space:nowrap}
figure{margin:14px 0;break-inside:avoid}
.pairoffigures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,420px),1fr));gap:6px 28px}
.three{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,300px),1fr));gap:8px 20px}
svg{max-width:100%;height:auto;display:block;font-family:inherit}
.scroll{overflow-x:auto;margin:12px 0}
.tall{max-height:88vh;overflow:auto}
.tall thead th{position:sticky;top:0;background:var(--bg);z-index:2}
.tall tbody th{z-index:1}
table{border-collapse:collapse;font-size:14px}
th,td{padding:4px 9px;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
table.big{font-size:12px;line-height:1.3}
table.big td{text-align:right;padding:3px 6px;font-variant-numeric:tabular-nums;white-space:nowrap}
table.big thead th{vertical-align:bottom;padding:3px 4px;font-weight:600}
table.big thead span{writing-mode:vertical-rl;transform:rotate(180deg);white-space:nowrap}
table.big tbody th{font-weight:600;white-space:nowrap;position:sticky;left:0;background:var(--bg)}
table.big tr.pair th{background:var(--panel);padding-top:8px}
table.big td.win{background:var(--c);color:var(--onc,var(--onfill));font-weight:700}
table.big td.near{box-shadow:inset 0 -3px var(--c)}
table.big td.biased{color:var(--soft);font-style:italic}
table.big td.none{color:var(--soft)}
td.name{white-space:nowrap}
.bad{color:var(--red);font-weight:650}
summary{cursor:pointer;color:var(--blue)}
text{fill:var(--ink);font-size:11px}
.tick,.note{fill:var(--soft)}.label{fill:var(--soft)}.heading{font-weight:650;font-size:12px}
.grid{stroke:var(--grid);stroke-width:1;fill:none}.axis{stroke:var(--soft);stroke-width:1;fill:none}
.curve{stroke:var(--c);stroke-width:1.8;fill:none;stroke-linejoin:round;stroke-linecap:round}
.curve.thin{stroke-width:1.1}.curve.dashed,.rule.dashed{stroke-dasharray:5 4}
.bar{stroke:var(--c);stroke-width:1.2;fill:none}
.dot{fill:var(--c);stroke:var(--bg);stroke-width:.7}
.dot.faint{fill-opacity:.55;stroke:none}
.band{fill:var(--c);fill-opacity:.2;stroke:none}
.block{fill:var(--c);fill-opacity:.45;stroke:var(--c);stroke-width:.7}
.rule{stroke:var(--c);stroke-width:1.2;fill:none}
.heat{stroke:var(--bg);stroke-width:1.5}
.heat.fill{fill:var(--c)}
.heat.none{fill:var(--grid)}
.heattext{font-size:10px}.heattext.on{fill:var(--onc,var(--onfill));font-weight:600}
.b1{fill:rgba(var(--better),.16)}.b2{fill:rgba(var(--better),.34)}.b3{fill:rgba(var(--better),.55)}
.w1{fill:rgba(var(--worse),.18)}.w2{fill:rgba(var(--worse),.4)}.w3{fill:rgba(var(--worse),.66)}
.pixels{image-rendering:pixelated}
.data{font-size:12.5px;margin:2px 0 14px;color:var(--soft);overflow-wrap:anywhere}
.data code{font-size:12px}
.legend{display:flex;flex-wrap:wrap;gap:3px 16px}
.ink{--c:var(--ink)}.soft{--c:var(--soft)}
.c-grey{--c:var(--grey)}.c-orange{--c:var(--orange)}.c-pink{--c:var(--pink)}.c-yellow{--c:var(--yellow)}
.c-red{--c:var(--red)}.c-blue{--c:var(--blue)}.c-sky{--c:var(--sky)}.c-green{--c:var(--green)}
.swatch{display:inline-block;width:11px;height:11px;border-radius:3px;background:var(--c);
margin-right:6px;vertical-align:-1px}
.shots{display:grid;grid-template-columns:repeat(auto-fill,minmax(215px,1fr));gap:16px 14px;margin:14px 0}
.shots figure{margin:0}
.shots img{width:100%;display:block;image-rendering:pixelated;border-radius:4px}
.shots img+img{margin-top:5px}
.shots figcaption{margin-top:5px;line-height:1.4}
.shots b{color:var(--ink)}
.good{color:var(--green);font-weight:650}
.open{color:var(--soft);font-weight:650}
footer{margin-top:50px;padding-bottom:40px}
@media (max-width:560px){body{font-size:15px}h1{font-size:25px}main,header,footer{padding-left:14px;
padding-right:14px}figure.map{overflow-x:auto}figure.map svg{max-width:none}}
@media print{body{font-size:11pt}main,header,footer{max-width:none}nav{display:none}
.pairoffigures{grid-template-columns:1fr 1fr}.three{grid-template-columns:1fr 1fr 1fr}
.cards{grid-template-columns:1fr 1fr 1fr}
.scroll,.tall{overflow:visible;max-height:none}.tall thead th{position:static}table.big{font-size:7pt}table.big td,table.big th{padding:1px 2px}
h2{break-after:avoid}.win,.swatch,.heat,.band,.block,.dot{print-color-adjust:exact;
-webkit-print-color-adjust:exact}}
)css";

}  // namespace app::report
